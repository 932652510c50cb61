"""The period of a recorded reference: a recording holds where the tip was wanted, not the formula of it."""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from controller.experiments.metrics import SWING_MIN

Array = np.ndarray[Any, Any]
TOLERANCE = 0.02
"""Rows one period apart agree to this share of the swing: a period need not end on a tick."""


@dataclass(frozen=True)
class Period:
    """A reference that repeats itself every `rows` rows from row `start` on, to the end."""

    rows: int
    start: int
    harmonics: tuple[int, int]
    """How often x and y swing in one period, by their largest harmonic."""

    def cycles(self, n: int) -> list[tuple[int, int]]:
        """First row and end of every whole cycle among n rows."""
        return list(pairwise(range(self.start, n + 1, self.rows)))


def find_period(p_ref: Array) -> Period | None:
    """The shortest period that the last two cycles of p_ref (n, 2) [m] agree on; None where there is none.

    The row at which the reference moves fastest near its end is sought in the rows before: each T at which it was
    there already is tried, and is the period if p_ref[i] = p_ref[i - T] over the last T rows.
    """
    n = len(p_ref)
    if n < 4 or not np.isfinite(p_ref).all():
        return None
    speed = np.linalg.norm(np.diff(p_ref, axis=0), axis=1)
    anchor = n - n // 4 + int(np.argmax(speed[n - n // 4 - 1 :]))
    distance = np.linalg.norm(p_ref[max(0, anchor - n // 2) : anchor + 1] - p_ref[anchor], axis=1)[::-1]
    for rows in _visits(distance, TOLERANCE * _swing(p_ref[n // 2 :])):
        last = p_ref[n - rows :]
        if n >= 2 * rows and _swing(last) >= SWING_MIN and _apart(p_ref[n - 2 * rows :], rows).max() <= _bound(last):
            return Period(rows, _begin(p_ref, rows, _bound(last)), _harmonics(last))
    return None


def _visits(distance: Array, near: float) -> list[int]:
    """Where `distance` is smallest in each stretch of it that is below `near`, but for the first, at 0."""
    edges = np.flatnonzero(np.diff((distance <= near).astype(np.int8), prepend=0, append=0))
    return [int(begin + np.argmin(distance[begin:end])) for begin, end in edges.reshape(-1, 2)[1:]]


def _begin(p_ref: Array, rows: int, bound: float) -> int:
    """The first row from which on p_ref repeats itself."""
    unlike = np.flatnonzero(_apart(p_ref, rows) > bound)
    return int(unlike[-1]) + 1 if len(unlike) else 0


def _harmonics(p: Array) -> tuple[int, int]:
    """The largest harmonic of each axis of one period p (n, 2)."""
    x, y = (1 + int(np.argmax(np.abs(np.fft.rfft(p[:, j]))[1:])) for j in range(2))
    return x, y


def _apart(p: Array, rows: int) -> Array:
    return np.asarray(np.linalg.norm(p[rows:] - p[:-rows], axis=1))


def _bound(p: Array) -> float:
    return TOLERANCE * _swing(p)


def _swing(p: Array) -> float:
    """Diagonal of the box around p (n, 2) [m]."""
    return math.hypot(*(float(extent) for extent in np.ptp(p, axis=0)))
