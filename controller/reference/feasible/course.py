"""What a path is: where its shape begins after an approach of its own, and whether it steps or repeats."""

from typing import NamedTuple

import numpy as np

from controller.arrays import Array
from controller.reference.period import Rhythm, repeats_from, rhythm, size, strongest

JUMP_SPEED, JUMP_TIME = 0.5, 0.1
"""A path that holds still jumps where it is faster [m/s], for no longer [s]: a file has a row every so often."""
STEP_MIN = 3e-3
"""What jumps less far was rounded [m]."""
TORN_SPEED = 2.0
"""Any path jumps where it is faster [m/s]; no arm of ours is."""
HELD = 1e-3
"""What stays within this holds still [m]."""
LEAD = 10.0
"""An approach of a file's own is over by then [s], or it is the shape."""
PAPER_LEAD = 2.0
"""How long it is where nothing shows its end [s] (paper, "2 second" start)."""
WINDOW = 0.02
"""Time over which a speed is taken, so that rounded points have one [s]."""
AWAY = 0.01
"""An approach goes further than this [m]."""
PAUSE = 0.03
"""An approach pauses where its speed falls below this share of its largest."""


class Course(NamedTuple):
    """How a path goes."""

    start: int
    """Row at which the shape begins; 0 unless the path brings its own approach."""
    steps: tuple[int, ...] = ()
    """Rows at which a step begins, the first of them at `start`."""
    frequency: float | None = None
    """[Hz], of the whole shape, or of its slower axis."""
    axis_frequencies: tuple[float, float] | None = None
    """[Hz] at which x and y swing, where that is not `frequency` for both (an eight, a Lissajous figure)."""


def course(p: Array, dt: float, from_rest: bool, start: int | None = None, frequency: float | None = None) -> Course:
    """The course of p (n, 2) [m], sampled every dt [s]; `from_rest`: whether it begins at rest, so approaches first.

    `start` [row] and `frequency` [Hz] need not be found if they are given.
    """
    steps = tuple(row for row in steps_of(p, dt, from_rest) if row >= (start or 0))
    if steps:
        return Course(steps[0] if start is None else start, steps, frequency)
    found = rhythms(p[start or 0 :], dt, frequency)
    if start is None:
        start = max(one.start for one in found) if found else lead_rows(p, dt) if from_rest else 0
    if found is not None:
        x, y = (one.frequency for one in found)
    elif frequency is not None:
        x = y = frequency
    else:
        return Course(start)
    axes = strongest(p[start:, 0], x, dt), strongest(p[start:, 1], y, dt)
    slow = x if x == y else min(axes)
    return Course(start, (), slow, None if axes == (slow, slow) else axes)


def rhythms(p: Array, dt: float, frequency: float | None) -> tuple[Rhythm, Rhythm] | None:
    """How x and y of p (n, 2) [m] repeat at its end, at `frequency` [Hz] if that is known.

    Together, or else each by itself: a Lissajous figure may need longer to come back than the file is, though both axes
    swing regularly.
    """
    if frequency is not None:
        start = repeats_from(p, 1.0 / (frequency * dt))
        return None if start is None else (Rhythm(frequency, start),) * 2
    if whole := rhythm(p, dt):
        return whole, whole
    x, y = rhythm(p * [1.0, 0.0], dt), rhythm(p * [0.0, 1.0], dt)
    return None if x is None or y is None else (x, y)


def speeds(p: Array, dt: float) -> Array:
    """Speed (n - 1,) [m/s] from each row of p (n, 2) [m] to the next."""
    found: Array = np.linalg.norm(np.diff(p, axis=0), axis=1) / dt
    return found


def torn(p: Array, dt: float) -> bool:
    """Whether p (n, 2) [m] jumps: its velocity is that of the sampling."""
    return bool((speeds(p, dt) > TORN_SPEED).any())


def steps_of(p: Array, dt: float, from_rest: bool) -> tuple[int, ...]:
    """Rows at which p (n, 2) [m] jumps, if it holds still in between; each the first that has left the old place.

    Before the first jump a path `from_rest` may approach; any other has to hold still there too.
    """
    edges = np.flatnonzero(np.diff(speeds(p, dt) > JUMP_SPEED, prepend=False, append=False))
    begins, ends = edges[::2], edges[1::2]
    far = np.linalg.norm(p[ends] - p[begins], axis=1) > STEP_MIN
    begins, ends = begins[far], ends[far]
    if not begins.size or (ends - begins).max() * dt > JUMP_TIME:
        return ()
    places = [p[begin : end + 1] for begin, end in zip([0, *ends], [*begins, len(p) - 1], strict=True)]
    approaches = int(from_rest and begins[0] * dt <= LEAD)
    if any(size(place) > HELD for place in places[approaches:]):
        return ()
    return tuple(int(begin) + 1 for begin in begins)


def lead_rows(p: Array, dt: float) -> int:
    """Rows of the approach with which p (n, 2) [m] begins at rest: up to its first pause, else the paper's; 0 if short.

    The pause ends where the velocity changes most.
    """
    window, room = round(WINDOW / dt), min(len(p), round(LEAD / dt))
    speed = np.linalg.norm(p[window:room] - p[: room - window], axis=1)
    peak = np.maximum.accumulate(speed)
    still = (speed < PAUSE * peak) & (np.linalg.norm(p[: len(speed)] - p[0], axis=1) > AWAY)
    if still.any():
        begin = int(np.argmax(still))
        moving = np.flatnonzero(~still[begin:])
        if moving.size:
            end = begin + int(moving[0]) + window
            change = np.linalg.norm(np.diff(p[begin : end + 1], 2, axis=0), axis=1)
            return begin + 1 + int(np.argmax(change))
    paper = round(PAPER_LEAD / dt)
    return paper if len(p) > paper + window else 0
