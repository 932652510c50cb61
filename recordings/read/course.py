"""What lies where in a recording: its run, and what was before, between and after; and the run's own clock."""

from itertools import pairwise
from pathlib import Path
from typing import Literal

import numpy as np

from controller.arrays import Mask, Values
from controller.errors import RecordingError
from controller.schema.layout import Model
from controller.schema.modes import Mode
from recordings.format import sidecar
from recordings.read.reader import read_start

Kind = Literal["before", "approach", "run", "pause", "after"]
EARLIEST = 15.0
"""So long before its button a recording may begin [s]: 10 s are in memory, and to begin takes a moment."""


class Stretch(Model):
    """From `start` to `end` [s] since the first row; the next one begins where it ends."""

    kind: Kind
    """`before`: what was in memory; `approach`: led onto the path, after a pause too; `pause`: between legs of a run;
    `run`: what the recording is of, which without a run is all since it was begun."""
    start: float
    end: float


def followed_rows(mode: Values, approach: Values | None) -> Mask:
    """Which rows (n,) are of runs that began in the recording, without those that are known to lead into them.

    Without any such note the rows in mode TRACK. A recording begins with what was in memory, which may be the end of an
    earlier run: only stretches in TRACK with a noted `approach` (n,) of bool count then.
    """
    tracked = np.asarray(mode == Mode.TRACK)
    if approach is None:
        return tracked
    stretch = np.cumsum(tracked & ~np.concatenate([[False], tracked[:-1]]))
    noted = np.unique(stretch[tracked & approach])
    return np.asarray(tracked & np.isin(stretch, noted) & ~approach)


def stretches(t: Values, mode: Values, approach: Values | None, begun: float) -> list[Stretch]:
    """Of rows at t (n,) [s], rising from 0; `begun` is when the recording was, for those without a run [s]."""
    if not len(t):
        return []
    run = followed_rows(mode, approach)
    begun = min(begun, float(t[-1]))
    if approach is None and not run[t >= begun].any():  # the end of an earlier run was in memory
        run[:] = False
    if not run.any():
        return _named([("before", 0.0), ("run", begun)], float(t[-1]))
    last = np.flatnonzero(run)[-1]
    row = np.arange(len(t))
    led = approach & (mode == Mode.TRACK) & (row <= last) if approach is not None else np.zeros(len(t), bool)
    lead = int(np.flatnonzero(led | run)[0])
    kinds = np.select([run, led, row < lead, row > last], [0, 1, 2, 3], 4)
    changes = [0, *(np.flatnonzero(np.diff(kinds)) + 1)]
    names: tuple[Kind, ...] = ("run", "approach", "before", "after", "pause")
    return _named([(names[kinds[i]], float(t[i])) for i in changes], float(t[-1]))


def run_clock(t: Values, parts: list[Stretch]) -> Values:
    """How long the run had been followed at t (n,) [s], without approaches and pauses; nan where it was not."""
    clock, passed = np.full(len(t), np.nan), 0.0
    for leg in legs(parts):
        inside = (t >= leg.start) & ((t < leg.end) | (leg is parts[-1]))
        clock[inside] = t[inside] - leg.start + passed
        passed += leg.end - leg.start
    return clock


def at_run_clock(clock: float, parts: list[Stretch]) -> float:
    """The time since the first row at which the run had been followed for `clock` [s]."""
    rest, found = clock, 0.0
    for leg in legs(parts):
        found = leg.start + rest
        if found < leg.end:
            break
        rest -= leg.end - leg.start
    return found


def legs(parts: list[Stretch]) -> list[Stretch]:
    """The stretches of the run itself."""
    return [part for part in parts if part.kind == "run"]


def begun(path: Path) -> float:
    """How long after its first row the recording in `path` was begun [s]; 0 where its description does not say."""
    try:
        described = sidecar.read(path.parent, path.stem)
    except RecordingError:
        return 0.0
    before = described.started.timestamp() - read_start(path) * 1e-9
    return before if 0.0 < before < EARLIEST and not described.imported else 0.0


def _named(begins: list[tuple[Kind, float]], end: float) -> list[Stretch]:
    found = [Stretch(kind=a[0], start=a[1], end=b[1]) for a, b in pairwise([*begins, ("after", end)])]
    return [part for part in found if part.end > part.start or part.kind == "run"]
