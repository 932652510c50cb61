"""Rayleigh damping B = alpha M + beta K about a measured damping ratio (paper, "Parameter Estimation")."""

import math
from typing import NamedTuple


class Rayleigh(NamedTuple):
    """B = alpha M + beta K, and the damping ratios between which every mode in the band then lies."""

    alpha: float
    """[1/s]."""
    beta: float
    """[s]."""
    zeta_low: float
    zeta_high: float


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
