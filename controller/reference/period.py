"""The frequency of a path that repeats."""

from collections.abc import Iterator

import numpy as np

from controller.kernels.rod import Array

REPEATS = 0.02
"""A path repeats where it is no further from its place a period ago than this share of its size."""
ODD = 1.0
"""How many of its points need not be: those beside a jump, which falls between two rows [%]."""
AWAY = 0.1
"""What is further off than this share of the size (rms) is no candidate for a period."""
SIZE_MIN, ROWS_MIN = 1e-3, 8
"""A smaller path is a point [m]; a shorter one has no period."""
DIGITS = 5
"""Significant digits of a frequency: as many as the period is good for."""


def frequency_of(p: Array, dt: float) -> float | None:
    """Frequency [Hz] of the path p (n, 2) [m] sampled every dt [s]; None unless at least two whole periods are alike.

    The lowest lag at which the path comes back on itself, found by autocorrelation, refined over all its repetitions.
    """
    size = float(np.linalg.norm(np.ptp(p, axis=0)))
    if size < SIZE_MIN or len(p) < ROWS_MIN:
        return None
    apart = misfit(p)
    for lag in returns(apart[: len(p) // 2 + 1], AWAY * size):
        period = refined(apart, lag)
        if repeats(p, period, REPEATS * size):
            return float(f"{1.0 / (period * dt):.{DIGITS}g}")
    return None


def misfit(p: Array) -> Array:
    """Rms distance (n,) [m] between p (n, 2) and itself, by lag [rows]."""
    n, q = len(p), p - p.mean(axis=0)
    spectrum = np.fft.rfft(q, 2 * n, axis=0)
    product = np.fft.irfft(np.abs(spectrum) ** 2, 2 * n, axis=0)[:n].sum(axis=1)
    energy = np.concatenate([[0.0], np.cumsum(np.sum(q**2, axis=1))])
    lag = np.arange(n)
    square = energy[n - lag] + energy[n] - energy[lag] - 2.0 * product
    apart: Array = np.sqrt(np.maximum(square, 0.0) / (n - lag))
    return apart


def returns(apart: Array, bound: float) -> Iterator[int]:
    """The best lag of every stretch in which `apart` (n,) [m] is back below `bound`."""
    near = apart <= bound
    ends = np.flatnonzero(np.diff(near, append=False)) + 1
    begins = np.flatnonzero(np.diff(near)) + 1
    for begin in begins[near[begins]]:
        end = ends[ends > begin][0]
        yield int(begin + np.argmin(apart[begin:end]))


def refined(apart: Array, lag: int) -> float:
    """Period [rows, not whole] near `lag`, from the last multiple of it that still overlaps by half a period."""
    period = vertex(apart, lag)
    for times in range(2, int((len(apart) - 0.5 * lag) / period) + 1):
        near = round(times * period)
        if near > len(apart) - 2:
            break
        period = vertex(apart, near) / times
    return period


def vertex(apart: Array, lag: int) -> float:
    """Lowest point of the parabola through the squares of `apart` about `lag` [rows]."""
    before, at, after = apart[lag - 1 : lag + 2] ** 2
    bend = before - 2.0 * at + after
    return lag + float(np.clip(0.5 * (before - after) / bend, -0.5, 0.5)) if bend > 0.0 else float(lag)


def repeats(p: Array, period: float, tolerance: float) -> bool:
    """Whether p (n, 2) is within `tolerance` [m] of itself a period [rows] later, over two periods and ODD apart."""
    if len(p) < 2.0 * period - 0.5:
        return False
    at = np.arange(len(p))
    here = at[at + period <= len(p) - 1]
    later = np.column_stack([np.interp(here + period, at, p[:, j]) for j in range(2)])
    return float(np.percentile(np.linalg.norm(later - p[here], axis=1), 100.0 - ODD)) <= tolerance
