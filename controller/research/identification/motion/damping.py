"""Damping ratio and frequency of free decays (paper, "Parameter Estimation"): by their peaks, then by all samples."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from controller.arrays import Array
from controller.errors import DataError
from controller.research.identification.motion.swings import Interval, combined, fit_swing, with_scatter

RESOLUTION = 1e-4
"""Noise is taken to be at least this share of the highest displacement."""

CLEAR = 4.0
"""A peak stands out of the noise when it is this many of the noise's standard deviations high."""

WINDOW = 1.0 / 6.0
"""Samples within this share of a half period about a peak carry its parabola; every peak of a decay is the same shape
scaled, so what the parabola misses is the same factor for all of them and leaves the decrement alone."""

END = 10
"""The end of a recording is its last tenth; the rest is no farther off than it still swings there."""

REST_NEEDS = 5
"""Peaks from which on a decay's own rest is corrected, too."""


ZETA_LEAST = 1e-4
"""Where the search by samples begins at least."""

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
    noise: float
    """Standard deviation of a sample of this decay, same unit."""


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
    """Standard deviation of ln(peak) about the straight line beyond the noise [1]: what a linear model cannot say."""

    @property
    def omega(self) -> float:
        """Undamped angular frequency [rad/s]."""
        return self.omega_d.value / math.sqrt(1.0 - self.zeta.value**2)


def log_decrement(decays: Sequence[tuple[Array, Array]]) -> Decrement:
    """Damping ratio and damped frequency common to `decays`, each t (n,) [s] and displacement from rest s (n,).

    ln |s_j| = c - j delta / 2 over the half periods j: one line per decay with a common slope. The variance of ln |s_j|
    is (noise / s_j)^2 plus a common one, as large as the scatter asks for: real damping changes with amplitude. A
    decay's own rest is corrected with it and the peaks found again. From there each decay's samples say the rest
    (swings.py), from its first peak to half a period after its last.
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
        signals = [(t, _moved(s, rest)) for (t, s, _), rest in zip(found, rests, strict=True)]
    by_peaks = half_delta / math.hypot(math.pi, half_delta), math.pi / _half_period(peaks)
    zeta, omega_d = _by_samples([(t, s) for t, s, _ in found], peaks, *by_peaks)
    return Decrement(zeta, omega_d, tuple(peaks), misfit)


def _by_samples(
    signals: Sequence[tuple[Array, Array]], peaks: Sequence[Peaks], zeta: float, omega_d: float
) -> tuple[Interval, Interval]:
    """Ratio and frequency [rad/s] by all samples of the signals; DataError where they tell none."""
    swings = []
    for (t, s), one in zip(signals, peaks, strict=True):
        inside = (t >= one.t[0]) & (t <= one.t[-1] + math.pi / omega_d)
        swings.append(fit_swing(t[inside], s[inside], max(zeta, ZETA_LEAST), omega_d))
    told = [one for one in swings if one is not None]
    if not told:
        raise DataError("no decay tells a damping ratio above 0")
    freedom = min(one.freedom for one in told)
    values = ([one.zeta for one in told], [one.omega_d for one in told])
    return (
        combined(values[0], [one.variance[0] for one in told], freedom),
        combined(values[1], [one.variance[1] for one in told], freedom),
    )


def find_peaks(t: Array, s: Array) -> Peaks:
    """Extremes of a decay t (n,) [s], s (n,) between its crossings of zero, placed between samples by a parabola."""
    noise = max(noise_of(s), RESOLUTION * float(np.abs(s).max(initial=0.0)))
    tops = np.array([int(run[np.argmax(np.abs(s[run]))]) for run in _half_waves(s, CLEAR * noise)], np.int64)
    if tops.size < 2:
        return Peaks(np.zeros(0), np.zeros(0), np.zeros(0), noise)
    reach = max(1, round(WINDOW * float(np.median(np.diff(tops)))))
    keep = (tops >= reach) & (tops + reach < s.size)
    refined = [_vertex(t[i - reach : i + reach + 1], s[i - reach : i + reach + 1]) for i in tops[keep]]
    at, value = np.array(refined, np.float64).reshape(-1, 2).T
    return Peaks((np.flatnonzero(keep) - np.argmax(keep)).astype(np.float64), at, value, noise)


def local_ratios(peaks: Peaks) -> tuple[Array, Array]:
    """Geometric mean of each two neighbouring peaks (n-1,), and the damping ratio that the two alone say (n-1,)."""
    height = np.abs(peaks.s)
    fall = np.log(height[:-1] / height[1:]) / np.diff(peaks.turn)
    return np.sqrt(height[:-1] * height[1:]), fall / np.hypot(math.pi, fall)


def noise_of(s: Array) -> float:
    """Standard deviation of white noise on a smooth signal s (n,), from its third differences."""
    if s.size < 4:
        return 0.0
    return float(np.median(np.abs(np.diff(s, 3)))) / (0.6745 * math.sqrt(20.0))


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


def _moved(s: Array, rest: float) -> Array:
    """Displacement s (n,) from a corrected rest, which lies within what the end of the recording still does."""
    end = s[-(s.size // END) :]
    return s - float(np.clip(rest, end.min(initial=0.0), end.max(initial=0.0)))


def _common_slope(peaks: Sequence[Peaks]) -> tuple[float, Array, float]:
    """Half the decrement, each decay's correction of its rest, and the scatter beyond the noise.

    With s_j = A_j + r, ln |s_j| = ln |A_j| + r / s_j to first order: an error r of the rest is one more linear unknown.
    """
    own_rest = [one.s.size >= REST_NEEDS for one in peaks]
    rows = [_one_hot(i, len(peaks), one) for i, one in enumerate(peaks)]
    slope = np.concatenate([-one.turn for one in peaks])[:, None]
    rest = np.concatenate([hot / one.s[:, None] for hot, one in zip(rows, peaks, strict=True)])[:, own_rest]
    right = np.concatenate([np.log(np.abs(one.s)) for one in peaks])
    unknowns, scatter = with_scatter(np.hstack([slope, np.concatenate(rows), rest]), right, _noise_share(peaks))
    rests = np.zeros(len(peaks))
    rests[own_rest] = unknowns[1 + len(peaks) :]
    return float(unknowns[0]), rests, scatter


def _half_period(peaks: Sequence[Peaks]) -> float:
    """The common time between a peak and the next [s]."""
    rows = np.concatenate([_one_hot(i, len(peaks), one) for i, one in enumerate(peaks)])
    turn = np.concatenate([one.turn for one in peaks])[:, None]
    t = np.concatenate([one.t for one in peaks])
    usual = float(np.median(np.concatenate([np.diff(one.t) for one in peaks])))
    return float(with_scatter(np.hstack([turn, rows]), t, usual * _noise_share(peaks))[0][0])


def _noise_share(peaks: Sequence[Peaks]) -> Array:
    """Noise over peak, of all peaks in turn: the standard deviation of ln(peak)."""
    return np.concatenate([one.noise / np.abs(one.s) for one in peaks])


def _one_hot(i: int, count: int, one: Peaks) -> Array:
    return np.tile(np.eye(count)[i], (one.s.size, 1))
