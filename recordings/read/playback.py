"""What the plan view shows of a recording, 50 times a second: little enough to keep an hour of it in memory."""

from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np

from controller.arrays import Values
from controller.errors import RecordingError
from controller.schema.actuator import Actuator
from recordings.format.chunks import numbers, widened
from recordings.format.signals import BACKBONES, GROUPS, MARKERS, flip
from recordings.read.reader import read_about

KEEP_EVERY = 20
"""One tick of this many is kept."""
PLAN = {group.path: group for group in GROUPS if group.path in ("/tip/x", "/tip/y", "/state")}
WIDTHS = {**{path: len(group.series) for path, group in PLAN.items()}, **dict.fromkeys(BACKBONES, 42), MARKERS: 20}
FIELDS = ("target", "p_ref", "p_meas", "mode", "sensed", "markers", "backbone", "twin_backbone")


class PlaybackRows:
    """Rows of FIELDS at times `t` (n,) [s] from the start, n >= 1, of a recording of `actuator`."""

    def __init__(self, t: Values, fields: dict[str, Values], actuator: Actuator) -> None:
        self.t, self.actuator = t, actuator
        self._fields = fields

    @property
    def duration(self) -> float:
        """Time of the last row [s]."""
        return float(self.t[-1])

    def row(self, at: float) -> dict[str, Values]:
        """The row in force at the time `at` [s]."""
        i = max(0, int(np.searchsorted(self.t, at, side="right")) - 1)
        return {name: values[i] for name, values in self._fields.items()}

    def trail(self, at: float, seconds: float) -> Values:
        """The measured tip over the last `seconds` before `at`: (k,2) [m]."""
        first, end = np.searchsorted(self.t, [at - seconds, at], side="right")
        points = self._fields["p_meas"][first:end]
        return np.asarray(points[np.isfinite(points).all(axis=1)])


def read_playback(path: Path) -> PlaybackRows:
    """Rows for the playback of the recording in `path`; RecordingError if it holds no rows or cannot be read."""
    try:
        found = _collect(path)
        info, _ = read_about(path)
    except RuntimeError as error:
        raise RecordingError(f"{path.name} cannot be played: {error}") from error
    t = found["/tip/x"][0]
    if not len(t):
        raise RecordingError(f"{path.name} holds no rows")
    fields = _scalars({path: _at(found[path], t) for path in PLAN})
    fields["markers"] = _at(found[MARKERS], t).reshape(-1, 10, 2)
    for entity, name in BACKBONES.items():
        fields[name] = flip(_at(found[entity], t).reshape(-1, 21, 2))
    return PlaybackRows((t - t[0]) * 1e-9, fields, info.parameters.actuator)


def _collect(path: Path) -> dict[str, tuple[Values, Values]]:
    """For each entity times [ns] and float32 values (k, width) in their order, thinned chunk by chunk.

    Nothing is told by its tick: those of a rig that restarted begin again.
    """
    from rerun.chunk import RrdReader  # a server only passes the order on

    parts: dict[str, list[tuple[Values, Values]]] = defaultdict(list)
    for chunk in RrdReader(path).stream().filter(content=[*WIDTHS]):
        batch, entity = chunk.to_record_batch(), str(chunk.entity_path)
        if "t" in batch.schema.names and (part := _thinned(batch, entity)) is not None:
            parts[entity].append(part)
    return {entity: _joined(parts[entity], width) for entity, width in WIDTHS.items()}


def _thinned(batch: Any, entity: str) -> tuple[Values, Values] | None:
    component = "LineStrips2D:strips" if entity in BACKBONES else "Scalars:scalars"
    if component not in batch.schema.names:
        return None
    t, tick = batch.column("t").cast("int64").to_numpy(), batch.column("tick").to_numpy()
    values = widened(np.asarray(numbers(batch.column(component)), np.float32), len(tick), WIDTHS[entity])
    # Markers come when they are measured, not on the grid of ticks.
    keep = np.ones(len(tick), bool) if entity == MARKERS else tick % KEEP_EVERY == 0
    return t[keep], values[keep]


def _joined(parts: list[tuple[Values, Values]], width: int) -> tuple[Values, Values]:
    if not parts:
        return np.empty(0, np.int64), np.empty((0, width), np.float32)
    t, values = (np.concatenate(column) for column in zip(*parts, strict=True))
    order = np.argsort(t, kind="stable")
    return t[order], values[order]


def _at(column: tuple[Values, Values], t: Values) -> Values:
    """The values in force at `t` (n,) [ns]: the last written at or before it, nan before the first."""
    written, values = column
    at = np.searchsorted(written, t, side="right") - 1
    if not len(values):
        return np.full((len(t), values.shape[1]), np.nan, np.float32)
    return np.where(at[:, None] >= 0, values[np.maximum(at, 0)], np.nan)


def _scalars(tables: dict[str, Values]) -> dict[str, Values]:
    """The FIELDS among the series of PLAN; vectors (n,2), numbers (n,)."""
    out: dict[str, Values] = {}
    for path, values in tables.items():
        for column, series in enumerate(PLAN[path].series):
            if series.field not in FIELDS:
                continue
            if series.index is None:
                out[series.field] = values[:, column]
            else:
                out.setdefault(series.field, np.empty((len(values), 2), np.float32))[:, series.index] = values[
                    :, column
                ]
    return out
