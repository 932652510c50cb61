"""Damping ratio and frequency of free decays from their samples, with intervals that hold as often as they say.

Peaks alone tell them with a bias: noise makes the highest sample of a crest too high, the more the lower the crest.
Here each decay is r + exp(-sigma t) (a cos omega_d t + b sin omega_d t) with white noise, by least squares of its
samples; decays are then taken as draws from what the arm does, which may differ from one to the next by more than
the noise.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import stats
from scipy.optimize import least_squares

from controller.arrays import Array

CONFIDENCE = 0.95
UNKNOWNS = 5
"""Of one decay."""
HALVINGS = 40
"""Of the interval for the scatter beyond the noise."""


@dataclass(frozen=True)
class Interval:
    """A value with its 95 % confidence interval."""

    value: float
    low: float
    high: float


class Swing(NamedTuple):
    """What one decay says."""

    zeta: float
    omega_d: float
    """[rad/s]."""
    variance: tuple[float, float]
    """Of both, by its noise."""
    freedom: int
    """Samples beyond the unknowns."""


def fit_swing(t: Array, s: Array, zeta: float, omega_d: float) -> Swing | None:
    """The decay t (n,) [s], s (n,), searched from a ratio and a frequency [rad/s] nearby; None where it tells none."""
    if t.size <= UNKNOWNS:
        return None
    begin = np.array([zeta * omega_d / math.sqrt(1.0 - zeta**2), omega_d])
    found = least_squares(_left_over, begin, x_scale=begin, args=(t, s))
    sigma, omega = found.x
    freedom = t.size - UNKNOWNS
    square = float(found.fun @ found.fun) / freedom
    J = np.asarray(found.jac)
    inner = J.T @ J
    if not (0.0 < sigma and 0.0 < omega and np.linalg.matrix_rank(inner) == 2):
        return None
    covariance = square * _spread_out(found.fun) * np.linalg.inv(inner)
    whole = math.hypot(sigma, omega)
    slope = np.array([omega**2, -sigma * omega]) / whole**3
    return Swing(sigma / whole, omega, (float(slope @ covariance @ slope), float(covariance[1, 1])), freedom)


def combined(values: Sequence[float], variances: Sequence[float], freedom: int) -> Interval:
    """The mean of what decays say and its interval, which counts how far they differ (Hartung and Knapp 2001).

    Weights are by noise and by the scatter between decays; of one decay alone, by its noise.
    """
    x, v = np.array(values), np.array(variances)
    if x.size == 1:
        half = float(stats.t.ppf((1 + CONFIDENCE) / 2, freedom)) * math.sqrt(v[0])
        return Interval(float(x[0]), float(x[0]) - half, float(x[0]) + half)
    found, scatter = with_scatter(np.ones((x.size, 1)), x, np.sqrt(v))
    mean, w = float(found[0]), 1.0 / (v + scatter**2)
    error = math.sqrt(float(w @ np.square(x - mean)) / ((x.size - 1) * w.sum()))
    half = float(stats.t.ppf((1 + CONFIDENCE) / 2, x.size - 1)) * error
    return Interval(mean, mean - half, mean + half)


def with_scatter(left: Array, right: Array, sigma: Array) -> tuple[Array, float]:
    """Least squares with variances sigma^2 (n,) plus a common one: unknowns, and the common sigma.

    The common variance is the smallest that lets the weighted squares fall to their expectation (Paule and Mandel
    1982).
    """
    freedom = right.size - int(np.linalg.matrix_rank(left))
    low, high = 0.0, float(np.ptp(right)) + 1e-12
    if _weighted(left, right, sigma)[1] > freedom:
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            excess = _weighted(left, right, np.hypot(sigma, middle))[1] > freedom
            low, high = (middle, high) if excess else (low, middle)
    return _weighted(left, right, np.hypot(sigma, low))[0], low


def _weighted(left: Array, right: Array, sigma: Array) -> tuple[Array, float]:
    """Unknowns and sum of weighted squares."""
    A, y = left / sigma[:, None], right / sigma
    unknowns = np.asarray(np.linalg.lstsq(A, y)[0], np.float64)
    return unknowns, float(np.square(y - A @ unknowns).sum())


def _left_over(x: Array, t: Array, s: Array) -> Array:
    """What sigma [1/s] and omega_d [rad/s] leave of s (n,) with the best rest, sine and cosine."""
    from_first = t - t[0]
    fall = np.exp(-x[0] * from_first)
    basis = np.column_stack([np.ones(t.size), fall * np.cos(x[1] * from_first), fall * np.sin(x[1] * from_first)])
    return np.asarray(s - basis @ np.linalg.lstsq(basis, s, rcond=None)[0])


def _spread_out(residual: Array) -> float:
    """By how much neighbouring residuals that are alike widen what is known: 1 of white noise (AR(1))."""
    alike = float(residual[1:] @ residual[:-1] / max(float(residual @ residual), 1e-300))
    bounded = min(max(alike, 0.0), 0.99)
    return (1.0 + bounded) / (1.0 - bounded)
