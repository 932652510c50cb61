"""Several recordings side by side: figures, and how far each tip is from the first one's on the runs' clocks."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from controller.arrays import Values
from controller.system.progress import ProgressCallback, no_progress
from recordings.format.messages import Metrics, Recording
from recordings.read.course import begun, run_clock, stretches
from recordings.read.metrics import FIELDS, metrics_of
from recordings.read.reader import read_rows
from recordings.store.store import Store

Figures = dict[str, float | None]


@dataclass(frozen=True)
class Compared:
    """A recording and its figures: those of Metrics, `apart_rms` and `apart_max` [m]."""

    recording: Recording
    figures: Figures


def compared(store: Store, ids: Sequence[str], told: ProgressCallback = no_progress) -> list[Compared]:
    """In the order of `ids`, the first of which is what the others are held against. RecordingError as `Store`."""
    found: list[Compared] = []
    first: tuple[Values, Values] | None = None
    for id in ids:
        recording = store.find(id)
        path = store.path(id)
        rows = read_rows(path, ("p_meas", "mode") if recording.metrics else FIELDS)
        tip = run_tip(rows, begun(path))
        first = first or tip
        metrics = recording.metrics or _metrics(rows, recording)
        found.append(Compared(recording, metrics.model_dump() | apart(first, tip)))
        told(len(found) / len(ids))
    return found


def run_tip(rows: dict[str, Values], begun: float = 0.0) -> tuple[Values, Values]:
    """Times (k,) [s] on the run's own clock and points (k, 2) [m] at which the tip was seen.

    Of a recording without a run since it was `begun` [s].
    """
    t = (rows["t_ns"] - rows["t_ns"][:1]) * 1e-9
    mode = rows.get("mode", np.zeros(len(t)))
    clock = run_clock(t, stretches(t, mode, rows.get("approach"), begun))
    seen = np.isfinite(clock) & np.isfinite(rows["p_meas"]).all(axis=1)
    return clock[seen], rows["p_meas"][seen]


def apart(first: tuple[Values, Values], other: tuple[Values, Values]) -> Figures:
    """RMS and largest distance [m] of the other path from the first at the other's times that both have.

    The first is taken along straight lines between its points; null where they share no time.
    """
    t, p = first
    common = (other[0] >= t[0]) & (other[0] <= t[-1]) if len(t) else np.zeros(len(other[0]), bool)
    if not common.any():
        return {"apart_rms": None, "apart_max": None}
    at = other[0][common]
    there = np.column_stack([np.interp(at, t, p[:, axis]) for axis in (0, 1)])
    distance = np.linalg.norm(other[1][common] - there, axis=1)
    return {"apart_rms": float(np.sqrt((distance**2).mean())), "apart_max": float(distance.max())}


def _metrics(rows: dict[str, Values], recording: Recording) -> Metrics:
    """Those of a recording whose figures were not taken yet; of an imported one there are none."""
    return Metrics() if recording.imported else metrics_of(rows)
