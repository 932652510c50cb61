"""Damping ratio by logarithmic decrement, and Rayleigh damping about it (paper, "Parameter Estimation")."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import stats

from controller.errors import DataError
from controller.kernels.rod import Array

FLOOR = 0.02
"""Peaks below this share of a decay's highest peak are left out: friction and noise rule there."""

CLEAR = 4.0
"""A peak stands out of the noise when it is this many of the noise's standard deviations high."""

WINDOW = 1.0 / 6.0
"""Samples within this share of a half period about a peak carry its parabola; every peak of a decay is the same shape
scaled, so what the parabola misses is the same factor for all of them and leaves the decrement alone."""

REST_NEEDS = 5
"""Peaks from which on a decay's own rest is corrected, too."""


ROUNDS = 6
"""Times that the rests are corrected: a recording that stops early ends a tenth of the first peak off its rest."""


class Peaks(NamedTuple):
    """Extremes of one decay, in turn on either side of the rest."""

    turn: Array
    """Half periods since the first one, from 0 (n,)."""
    t: Array
    """(n,) [s]."""
    s: Array
    """Displacement from rest with its sign (n,), in the unit of the data."""


@dataclass(frozen=True)
class Interval:
    """A value with its 95 % confidence interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Decrement:
    """What free decays say about the mode that dominates them."""

    zeta: Interval
    """Damping ratio [1]."""
    omega_d: Interval
    """Damped angular frequency [rad/s]."""
    peaks: tuple[Peaks, ...]
    """Of each decay, corrected by its rest."""
    log_misfit: float
    """Weighted rms of ln(peak) about the straight line [1]."""

    @property
    def omega(self) -> float:
        """Undamped angular frequency [rad/s]."""
        return self.omega_d.value / math.sqrt(1.0 - self.zeta.value**2)


class Rayleigh(NamedTuple):
    """B = alpha M + beta K, and the damping ratios between which every mode in the band then lies."""

    alpha: float
    """[1/s]."""
    beta: float
    """[s]."""
    zeta_low: float
    zeta_high: float


def log_decrement(decays: Sequence[tuple[Array, Array]]) -> Decrement:
    """Damping ratio and damped frequency common to `decays`, each t (n,) [s] and displacement from rest s (n,).

    ln |s_j| = c - j delta / 2 over the half periods j: one line per decay with a common slope, weighted by |s_j|
    because the noise is the same on every peak. A decay's own rest is corrected with it and the peaks found anew.
    DataError when too few peaks stand out of the noise: 3 in one decay, or 2 in each of two.
    """
    signals = list(decays)
    for _ in range(ROUNDS):
        found = [(t, s, find_peaks(t, s)) for t, s in signals]
        found = [one for one in found if one[2].s.size > 1]
        peaks = [one for _, _, one in found]
        count = sum(one.s.size for one in peaks)
        if count < len(peaks) + 2:
            raise DataError(f"{count} peaks stand out of the noise: 3 in a decay, or 2 in each of two, are needed")
        half_delta, rests, misfit = _common_slope(peaks)
        signals = [(t, s - rest) for (t, s, _), rest in zip(found, rests, strict=True)]
    ratio = [slope / math.hypot(math.pi, slope) for slope in (half_delta.value, half_delta.low, half_delta.high)]
    return Decrement(Interval(*ratio), _frequency(peaks), tuple(peaks), misfit)


def find_peaks(t: Array, s: Array) -> Peaks:
    """Extremes of a decay t (n,) [s], s (n,) between its crossings of zero, placed between samples by a parabola."""
    height = float(np.abs(s).max(initial=0.0))
    band = max(FLOOR * height, CLEAR * noise_of(s))
    tops = np.array([int(run[np.argmax(np.abs(s[run]))]) for run in _half_waves(s, band)], np.int64)
    if tops.size < 2:
        return Peaks(np.zeros(0), np.zeros(0), np.zeros(0))
    reach = max(1, round(WINDOW * float(np.median(np.diff(tops)))))
    keep = (tops >= reach) & (tops + reach < s.size)
    refined = [_vertex(t[i - reach : i + reach + 1], s[i - reach : i + reach + 1]) for i in tops[keep]]
    at, value = np.array(refined, np.float64).reshape(-1, 2).T
    return Peaks((np.flatnonzero(keep) - np.argmax(keep)).astype(np.float64), at, value)


def noise_of(s: Array) -> float:
    """Standard deviation of white noise on a smooth signal s (n,), from its third differences."""
    if s.size < 4:
        return 0.0
    return float(np.median(np.abs(np.diff(s, 3)))) / (0.6745 * math.sqrt(20.0))


def rayleigh(zeta: float, omega_low: float, omega_high: float) -> Rayleigh:
    """(alpha, beta) that give both ends of the band [rad/s] the damping ratio `zeta`; every mode in between has less.

    alpha / (2 omega) + beta omega / 2 is lowest at the geometric mean of the ends. The measured mode is the lower end
    and keeps its own ratio; the paper asks for "a narrow range around" it.
    """
    beta = 2.0 * zeta / (omega_low + omega_high)
    alpha = beta * omega_low * omega_high
    return Rayleigh(alpha, beta, math.sqrt(alpha * beta), zeta)


def rayleigh_ratio(alpha: float, beta: float, omega: float) -> float:
    """Damping ratio of a mode at omega [rad/s] under B = alpha M + beta K."""
    return alpha / (2.0 * omega) + beta * omega / 2.0


def _half_waves(s: Array, band: float) -> list[Array]:
    """Indices of each stretch on one side of zero; a crossing counts when it has left the band on the other side."""
    outside = np.flatnonzero(np.abs(s) > band)
    if outside.size == 0:
        return []
    side = np.sign(s[outside])
    return np.split(outside, np.flatnonzero(np.diff(side)) + 1)


def _vertex(t: Array, s: Array) -> tuple[float, float]:
    """Time and value of the extreme of the parabola through t, s (n,) by least squares."""
    middle = t[t.size // 2]
    c, b, a = np.polynomial.polynomial.polyfit(t - middle, s, 2)
    shift = float(np.clip(-b / (2.0 * a), t[0] - middle, t[-1] - middle)) if a else 0.0
    return middle + shift, c + shift * (b + shift * a)


def _common_slope(peaks: Sequence[Peaks]) -> tuple[Interval, Array, float]:
    """Half the decrement, each decay's correction of its rest, and the weighted rms of what is left.

    With s_j = A_j + r, ln |s_j| = ln |A_j| + r / s_j to first order: an error r of the rest is one more linear unknown.
    """
    own_rest = [one.s.size >= REST_NEEDS for one in peaks]
    rows = [_one_hot(i, len(peaks), one) for i, one in enumerate(peaks)]
    slope = np.concatenate([-one.turn for one in peaks])[:, None]
    rest = np.concatenate([hot / one.s[:, None] for hot, one in zip(rows, peaks, strict=True)])[:, own_rest]
    right = np.concatenate([np.log(np.abs(one.s)) for one in peaks])
    weight = np.concatenate([np.abs(one.s) / np.abs(one.s).max() for one in peaks])
    unknowns, interval, misfit = _weighted(np.hstack([slope, np.concatenate(rows), rest]), right, weight)
    rests = np.zeros(len(peaks))
    rests[own_rest] = unknowns[1 + len(peaks) :]
    return interval, rests, misfit


def _frequency(peaks: Sequence[Peaks]) -> Interval:
    """Angular frequency: pi over the common time between a peak and the next [rad/s]."""
    rows = np.concatenate([_one_hot(i, len(peaks), one) for i, one in enumerate(peaks)])
    turn = np.concatenate([one.turn for one in peaks])[:, None]
    weight = np.concatenate([np.abs(one.s) / np.abs(one.s).max() for one in peaks])
    _, half, _ = _weighted(np.hstack([turn, rows]), np.concatenate([one.t for one in peaks]), weight)
    return Interval(math.pi / half.value, math.pi / half.high, math.pi / max(half.low, 1e-12))


def _one_hot(i: int, count: int, one: Peaks) -> Array:
    return np.tile(np.eye(count)[i], (one.s.size, 1))


def _weighted(left: Array, right: Array, weight: Array) -> tuple[Array, Interval, float]:
    """Weighted least squares: all unknowns, the first with its confidence interval, and the weighted rms misfit."""
    A, y = left * weight[:, None], right * weight
    unknowns = np.asarray(np.linalg.lstsq(A, y)[0], np.float64)
    freedom = y.size - np.linalg.matrix_rank(A)
    misfit = y - A @ unknowns
    variance = float(misfit @ misfit) / freedom * np.linalg.pinv(A.T @ A)[0, 0]
    half = float(stats.t.ppf(0.975, freedom)) * math.sqrt(variance)
    rms = math.sqrt(float(misfit @ misfit) / float(weight @ weight))
    return unknowns, Interval(float(unknowns[0]), float(unknowns[0]) - half, float(unknowns[0]) + half), rms
