"""The part at the end of a path that repeats, and its frequency.

What comes before it is no part of it, such as an approach from rest.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from controller.arrays import Array

REPEATS = 0.02
"""A path repeats where it is no further from its place in its last period than this share of that period's size."""
AWAY = 0.1
"""What is further off than this share of the size (rms) is no candidate for a period."""
LEAD = 2.5
"""An approach may be this long [s], and longer if the part that repeats is longer still."""
DRIFT = 3e-3
"""What moves by more than this share of the size from period to period, and by twice that in two, is a spiral."""
ALIKE = 3.0
"""The part begins where the path is further off than this many times what its later periods are apart."""
EXACT = 1e-6
"""What interpolation between the rows of an exact path leaves [m]."""
ODD = 1.0
"""How many points need not repeat: those beside a jump, which falls between two rows [%]."""
JUMP_ROWS = 3
"""This many rows in a row are off before the part; beside a jump, which falls between two rows, fewer."""
SIZE_MIN, ROWS_MIN = 1e-3, 8
"""A smaller path is a point [m]; a shorter one has no period [rows]."""
OVERLAP = 0.5
"""The last period comes back on what is before for this share of a period at least."""
PROBES = 32
"""Points of a period at which a lag is tried first."""
DIGITS = 5
"""Significant digits of a frequency: as many as the period is good for."""
HARMONICS = 40
"""Multiples of a path's frequency at which an axis may swing."""


class Rhythm(NamedTuple):
    """How a path repeats."""

    frequency: float
    """[Hz]."""
    start: int
    """Row from which on it repeats to its end."""


def rhythm(p: Array, dt: float) -> Rhythm | None:
    """How p (n, 2) [m], sampled every dt [s], repeats at its end; None unless half of it does, or all after LEAD."""
    found = repetition(p, dt)
    if found is None:
        return None
    period, start = found
    return Rhythm(float(f"{1.0 / (period * dt):.{DIGITS}g}"), start)


def repetition(p: Array, dt: float) -> tuple[float, int] | None:
    """Period [rows, not whole] and first row of a `rhythm`; its DIGITS would drift over thousands of periods.

    The lowest lag at which the end comes back on itself, refined over all its repetitions.
    """
    if len(p) < ROWS_MIN:
        return None
    for stretch in returns(apart(p), AWAY):
        period = refined(p, best(p, *stretch))
        start = repeats_from(p, period)
        if start is not None and start <= max(len(p) / 2, LEAD / dt) and not drifts(p, period):
            return period, start
    return None


def size(p: Array) -> float:
    """Diagonal of the box about p (n, 2) [m]."""
    return float(np.linalg.norm(np.ptp(p, axis=0)))


def apart(p: Array) -> Array:
    """Rms distance between the end of the last period and of the one before, over its size, by lag [rows].

    Seen at PROBES points of the period; inf for what is a point.
    """
    lag = np.arange(round(len(p) / (1.0 + OVERLAP)) + 1)
    square, low, high = np.zeros(lag.size), np.full((lag.size, 2), np.inf), np.full((lag.size, 2), -np.inf)
    for share in np.arange(PROBES) / PROBES:
        at = len(p) - 1 - np.round(share * lag).astype(int)
        here = p[np.maximum(at, 0)]
        if share <= OVERLAP:
            square += np.sum((here - p[np.maximum(at - lag, 0)]) ** 2, axis=1) / (OVERLAP * PROBES)
        low, high = np.minimum(low, here), np.maximum(high, here)
    sizes = np.linalg.norm(high - low, axis=1)
    off: Array = np.divide(np.sqrt(square), sizes, out=np.full(lag.size, np.inf), where=sizes >= SIZE_MIN)
    return off


def returns(off: Array, bound: float) -> Iterator[tuple[int, int]]:
    """Every stretch [begin, end) in which `off` (n,) is back below `bound`."""
    near = off <= bound
    ends = np.flatnonzero(np.diff(near, append=False)) + 1
    begins = np.flatnonzero(np.diff(near)) + 1
    for begin in begins[near[begins]]:
        yield int(begin), int(ends[ends > begin][0])


def best(p: Array, begin: int, end: int) -> int:
    """The lag in [begin, end) [rows] by which the last period of p (n, 2) repeats best, where there is one lowest."""
    rows = math.ceil(OVERLAP * begin)
    while end - begin > 2:
        middle = (begin + end) // 2
        if mean_square(p, middle - 1, rows) < mean_square(p, middle, rows):
            end = middle
        else:
            begin = middle
    return min(range(begin, end), key=lambda lag: mean_square(p, lag, rows))


def refined(p: Array, lag: int) -> float:
    """Period [rows, not whole] near `lag`, from the last multiple of it by which the end still repeats."""
    bound, rows = REPEATS * size(p[-lag:]), math.ceil(OVERLAP * lag)
    period = float(lag)
    for times in range(1, math.floor((len(p) - rows) / period) + 1):
        near = round(times * period)
        squares = [mean_square(p, near + step, rows) for step in (-1, 0, 1)]
        if times > 1 and not far(p, near, rows) <= bound:
            break
        period = (near + vertex(*squares)) / times
    return period


def distances(p: Array, lag: int, rows: int) -> Array:
    """Distances (m,) [m] of the last `rows` of p (n, 2) [m] from those `lag` rows before, as far as there are."""
    begin = max(len(p) - rows, lag)
    found: Array = np.linalg.norm(p[begin:] - p[begin - lag : len(p) - lag], axis=1)
    return found


def mean_square(p: Array, lag: int, rows: int) -> float:
    """Of the `distances` [m^2]; nan without any."""
    found = distances(p, lag, rows)
    return float(np.mean(found**2)) if found.size else math.nan


def far(p: Array, lag: int, rows: int) -> float:
    """The largest of the `distances` [m] but for ODD of them."""
    return float(np.percentile(distances(p, lag, rows), 100.0 - ODD))


def vertex(before: float, at: float, after: float) -> float:
    """Lowest point of the parabola through three values, at -1, 0 and 1, in [-0.5, 0.5]; 0 where it has none."""
    bend = before - 2.0 * at + after
    return min(max(0.5 * (before - after) / bend, -0.5), 0.5) if bend > 0.0 else 0.0


def deviation(p: Array, period: float) -> Array:
    """How far p (n, 2) [m] is from its place in the last period [rows]: (n - period,) [m], without that period."""
    at = np.arange(len(p))
    here = at[: max(0, math.ceil(len(p) - period - 1e-6))]
    there = here + np.floor((at[-1] - here) / period + 1e-9) * period
    last = np.column_stack([np.interp(there, at, p[:, j]) for j in range(2)])
    distance: Array = np.linalg.norm(last - p[here], axis=1)
    return distance


def repeats_from(p: Array, period: float) -> int | None:
    """Row from which on p (n, 2) [m] repeats every `period` [rows] to its end; None for too short a part."""
    off = deviation(p, period)
    bound = REPEATS * size(p[-math.ceil(period) :])
    about = first_row(off, bound)
    if about >= len(off) or len(p) - about < (1.0 + OVERLAP) * period - 1.0:
        return None
    level = float(np.percentile(off[about + (len(off) - about) // 4 :], 100.0 - ODD))
    return first_row(off, min(bound, ALIKE * level + EXACT))


def first_row(off: Array, bound: float) -> int:
    """Row after the last JUMP_ROWS successive ones at which `off` (n,) is above `bound`."""
    above = np.concatenate([[True] * JUMP_ROWS, off > bound])
    runs = np.lib.stride_tricks.sliding_window_view(above, JUMP_ROWS).all(axis=1)
    return int(np.flatnonzero(runs)[-1])


def drifts(p: Array, period: float) -> bool:
    """Whether p (n, 2) [m] is away after a `period` [rows], some twice as far after two, and further after three."""
    off, rows, back = deviation(p, period), math.floor(OVERLAP * period), math.floor(period)
    ends = [len(off) - k * back for k in range(3)]
    away = [float(np.median(off[max(0, end - rows) : end])) for end in ends if end > 0]
    if len(away) < 2 or away[0] <= DRIFT * size(p[-back:]):
        return False
    return 1.5 * away[0] < away[1] < 3.0 * away[0] and (len(away) < 3 or away[2] > 1.2 * away[1])


def strongest(p: Array, frequency: float, dt: float) -> float:
    """The multiple of `frequency` [Hz] at which p (n,) [m] swings most over whole periods; itself for none."""
    rows = math.floor(len(p) * frequency * dt + 1e-6) / (frequency * dt)
    q = p[: round(rows)]
    if not len(q):
        return frequency
    turn = np.exp(-2j * math.pi * frequency * dt * np.arange(len(q)))
    swing, swings = (q - q.mean()) / len(q), np.empty(HARMONICS)
    for k in range(HARMONICS):  # turn^(k+1) by products: as many exponentials take longer than all the rest of a plan
        swing = swing * turn
        swings[k] = abs(swing.sum())
    clear = max(swings) > max(0.25 * SIZE_MIN, 1.01 * swings[0])
    return frequency * (1 + int(np.argmax(swings))) if clear else frequency
