"""An alpha-beta filter of points in the plane, with the gains that their noise and their motion ask for.

In its steady state the innovations, what a sample brings that was not foreseen, have the variance
S = sigma^2 / (1 - alpha), with sigma^2 that of the noise, and beta = 2 (2 - alpha) - 4 (1 - alpha)^(1/2) (Kalata 1984).
So S, which the filter itself sees, says how large alpha should be. Not in the paper, which holds a sample until the
next.
"""

import math

from controller.arrays import Array
from controller.kernels.compiled import kernel
from controller.kernels.group import Group

ALPHA_MIN, ALPHA_MAX = 0.2, 0.9
"""Between them noise and motion choose. Below, feedback of a tip that no marker shows would swing."""
CHANCE = 1.3
"""Innovations up to this share of what noise explains are chance: their variance is that of few samples."""
INNOVATIONS_SHARE = 0.1
"""Of a new sample in the variance of the innovations."""


class AlphaBeta(Group):
    """The filters of n points."""

    x: Array
    """When they were seen last (n,2) [m]."""
    rate: Array
    """(n,2) [m/s]."""
    innovation: Array
    """Variance of what a sample brings that was not foreseen, of a coordinate (n,) [m^2]."""


@kernel
def begin_point(j: int, x: float, y: float, noise: float, point: AlphaBeta) -> None:
    """Begin point j at (x, y) [m], at rest; what it had is forgotten. Not in the paper. In place: point."""
    point.x[j, 0], point.x[j, 1] = x, y
    point.rate[j, 0] = point.rate[j, 1] = 0.0
    point.innovation[j] = noise


@kernel
def correct_point(j: int, x: float, y: float, apart: float, together: bool, noise: float, point: AlphaBeta) -> None:
    """Take in a sample (x, y) [m] of point j, `apart` [s] after its last, with noise of the variance `noise` [m^2].

    One that came `together` with others, held back on its way, tells no rate. Not in the paper: see the module.
    In place: point.
    """
    x_new, y_new = x - point.x[j, 0] - apart * point.rate[j, 0], y - point.x[j, 1] - apart * point.rate[j, 1]
    unforeseen = 0.5 * (x_new * x_new + y_new * y_new)
    point.innovation[j] += INNOVATIONS_SHARE * (unforeseen - point.innovation[j])
    alpha = alpha_of(point.innovation[j], noise)
    point.x[j, 0] += apart * point.rate[j, 0] + alpha * x_new
    point.x[j, 1] += apart * point.rate[j, 1] + alpha * y_new
    if not together:
        point.rate[j, 0] += beta_of(alpha) / apart * x_new
        point.rate[j, 1] += beta_of(alpha) / apart * y_new


@kernel
def alpha_of(innovation: float, noise: float) -> float:
    """Alpha by the variances of innovations and noise [m^2] (Kalata 1984). Not in the paper."""
    return min(max(1.0 - CHANCE * noise / innovation, ALPHA_MIN), ALPHA_MAX)


@kernel
def beta_of(alpha: float) -> float:
    """Beta by alpha (Kalata 1984). Not in the paper."""
    return 2.0 * (2.0 - alpha) - 4.0 * math.sqrt(1.0 - alpha)
