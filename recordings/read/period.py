"""The period of a recorded reference: a recording holds where the tip was wanted, not the formula of it."""

import math
from dataclasses import dataclass

import numpy as np

from controller.arrays import Values
from controller.reference.period import repeats_from, repetition, strongest
from controller.schema.parameters import DT

CYCLES_MIN = 2
"""Fewest whole cycles."""
SEARCHED = 100_000
"""Last rows in which a period is sought: it takes time."""
POINTS = 512
"""Of one cycle, for its harmonics."""
CLEAR = 0.25
"""A harmonic counts that has this share of the largest one."""
ROWS_SHORT = 0.5
"""So much may be missing to a whole cycle [rows]: a period is good for about that."""
ON_ROW = 1e-6
"""So near to a row a cycle ends on it [rows]."""
AFTER = 0.07
"""So much of a cycle later passes that look the same have parted, in any harmonic that matters."""
BREAK = 10.0
"""Rows that are this many times further apart than others have a pause between them."""


@dataclass(frozen=True)
class Period:
    """A reference that repeats itself every `rows` rows (not whole) from row `start` on, to the end."""

    rows: float
    start: int
    swings: tuple[float, float]
    """How often x and y swing from row to row, where they swing most."""

    def cycles(self, n: int) -> list[tuple[int, int]]:
        """First row and end of every whole cycle among n rows."""
        count, length = math.floor((n - self.start + ROWS_SHORT) / self.rows), math.ceil(self.rows - ON_ROW)
        begins = (min(self.start + math.floor(k * self.rows), n - length) for k in range(count))
        return [(begin, begin + length) for begin in begins]


def find_period(p_ref: Values, dt: float = DT) -> Period | None:
    """How p_ref (n, 2) [m], with rows every dt [s], repeats at its end as `repetition` sees it; None if it does not.

    It has to do so twice.
    """
    if not np.isfinite(p_ref).all():
        return None
    found = repetition(p_ref[-SEARCHED:], dt)
    if found is None:
        return None
    rows, start = found
    if len(p_ref) > SEARCHED:
        start = repeats_from(p_ref, rows) or 0
    if len(p_ref) - start < CYCLES_MIN * rows - 1.0:
        return None
    x, y = (strongest(p_ref[start:, axis], 1.0 / rows, 1.0) for axis in range(2))
    return Period(rows, start, (x, y))


def find_phase(t: Values, x: Values | None, y: Values | None) -> tuple[float | None, float]:
    """Period [s] of the reference x, y (n,) [m] at t (n,) [s], and when its first cycle begins; (None, 0) for none."""
    if x is None or y is None or len(t) < CYCLES_MIN:
        return None, 0.0
    p, steps = np.column_stack([x, y]), np.diff(t)
    steps = np.where(steps < BREAK * np.median(steps), steps, np.nan)
    found = find_period(p, float(np.nanmedian(steps)))
    if found is None:
        return None, 0.0
    period = found.rows * float(np.nanmean(steps[found.start :]))
    begin = t[-1] - (1.0 - cycle_start(last_cycle(p, found.rows))) * period
    first = float(t[found.start])
    return period, first + float((begin - first) % period)


def last_cycle(p: Values, rows: float) -> Values:
    """The last `rows` rows of p (n, 2) as POINTS, evenly: (POINTS, 2)."""
    at = len(p) - 1 - rows * (1.0 - np.arange(POINTS) / POINTS)
    return np.column_stack([np.interp(at, np.arange(len(p)), p[:, axis]) for axis in range(2)])


def cycle_start(cycle: Values) -> float:
    """The place [0, 1) in one cycle (n, 2) of a path at which it is said to begin, wherever that cycle was cut.

    A maximum of x, or of y where x does not swing so, in the lowest harmonic that is clear. Where that has several in
    a cycle, the one after which x + y is largest.
    """
    swings = np.fft.rfft(cycle, axis=0)[1 : len(cycle) // 4]
    k, axis = np.argwhere(np.abs(swings) >= CLEAR * np.abs(swings).max())[0]
    order = int(k) + 1
    first = -float(np.angle(swings[k, axis])) / (2.0 * math.pi)
    maxima = (first + np.arange(order)) / order % 1.0
    after = np.round((maxima + AFTER) * len(cycle)).astype(int) % len(cycle)
    return float(maxima[np.argmax(cycle[after].sum(axis=1))])
