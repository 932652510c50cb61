"""The period of a path that is only known by samples, measured or imported, and where its cycles begin."""

from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]

SAMPLES = 8192
ALIKE = 0.9
"""Least correlation with itself one period later."""


def find_phase(t: Array, x: Array | None, y: Array | None) -> tuple[float | None, float]:
    """Period [s] of the path x, y (n,) [m] over t (n,) [s], and when a cycle begins [s]; (None, 0) if it has none.

    The period is the lag of the autocorrelation's highest peak; a cycle begins where the fundamental has its maximum.
    """
    if x is None or y is None:
        return None, 0.0
    known = np.isfinite(x) & np.isfinite(y)
    if known.sum() < 64 or t[known][-1] <= t[known][0]:
        return None, 0.0
    even = np.linspace(t[known][0], t[known][-1], min(int(known.sum()), SAMPLES))
    path = np.interp(even, t[known], x[known]) + 1j * np.interp(even, t[known], y[known])
    path -= path.mean()
    step = even[1] - even[0]
    lag = _best_lag(path)
    return (None, 0.0) if lag is None else (lag * step, _cycle_start(even, path, lag * step))


def _best_lag(path: np.ndarray[Any, np.dtype[np.complex128]]) -> float | None:
    """First lag [samples] of a peak that comes near the highest, refined by a parabola; None without one."""
    count = len(path)
    spectrum = np.fft.fft(path, 2 * count)
    overlap = np.arange(count, 0, -1)
    energy = np.cumsum(np.abs(path) ** 2)
    both = np.sqrt(np.maximum(energy[::-1] * (energy[-1] - np.concatenate(([0.0], energy[:-1]))), 1e-300))
    alike = np.fft.ifft(np.abs(spectrum) ** 2).real[:count] / both
    alike[overlap < count // 3] = 0.0  # too little is left to compare
    below = np.flatnonzero(alike < 0.5)
    if not len(below):
        return None
    inner = np.arange(max(1, below[0]), count - 1)
    peaks = inner[(alike[inner] >= alike[inner - 1]) & (alike[inner] > alike[inner + 1]) & (alike[inner] > ALIKE)]
    if not len(peaks):
        return None
    best = peaks[alike[peaks] >= alike[peaks].max() - 0.02][0]
    left, middle, right = alike[best - 1 : best + 2]
    return float(best + 0.5 * (left - right) / (left - 2 * middle + right))


def _cycle_start(t: Array, path: np.ndarray[Any, np.dtype[np.complex128]], period: float) -> float:
    """Time [s] in the first period at which the fundamental of the component that moves more has its maximum."""
    turn = np.exp(-2j * np.pi * t / period)
    component = path.real if np.ptp(path.real) >= np.ptp(path.imag) else path.imag
    angle = np.angle((component * turn).sum())
    return float((-angle / (2 * np.pi) * period) % period)
