"""When a drawn path is where: at constant speed, or as fast as limits of speed and acceleration allow."""

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from controller.arrays import Array
from controller.errors import ParameterError
from controller.reference.feasible.bounds import Limits
from controller.reference.shapes import along, lengths

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

APART = 1e-9
"""Points that are nearer to one another are one [m]."""


class Ride(NamedTuple):
    """Speeds along a path; between two points v^2 is linear in s."""

    path: "CubicSpline"
    """Positions [m] by arc length."""
    s: Array
    """(m,) [m]."""
    v: Array
    """(m,) [m/s]."""
    t: Array
    """(m,) [s]."""

    def rows(self, dt: float) -> Array:
        """Rows (n, 2) [m] every dt [s], slowed a little, so that the end falls on a tick."""
        s, v, t = self.s, self.v, self.t
        at = np.linspace(0.0, t[-1], math.ceil(t[-1] / dt - 1e-9) + 1)
        i = np.clip(np.searchsorted(t, at, "right") - 1, 0, len(s) - 2)
        tau, a = at - t[i], (v[i + 1] ** 2 - v[i] ** 2) / (2.0 * (s[i + 1] - s[i]))
        found: Array = self.path(np.minimum(s[i] + v[i] * tau + 0.5 * a * tau**2, s[-1]))
        return found


def steady(path: Array, duration: float, dt: float) -> Array:
    """Rows (n, 2) every dt [s] at constant speed along `path` (m, 2) [m], through corners, in `duration` [s]."""
    ticks = max(1, round(duration / dt))
    return along(path, np.linspace(0.0, 1.0, ticks + 1))


def fastest(path: Array, limits: Limits) -> Ride:
    """The ride along a smooth `path` (m, 2) [m] from rest to rest that takes the least time within `limits`.

    The path is the cubic through its points. The speed v(s) is the largest with v <= v_max and
    (v v')^2 + (kappa v^2)^2 <= a_max^2 (Bobrow, Dubowsky, Gibson 1985; for these limits one pass each way finds it).
    """
    path = path[np.concatenate([[True], np.linalg.norm(np.diff(path, axis=0), axis=1) > APART])]
    if len(path) < 2:
        raise ParameterError("points: all are one")
    from scipy.interpolate import CubicSpline  # half a second, which a start of the server must not take

    s = lengths(path)
    spline = CubicSpline(s, path)
    v = profile(s, np.linalg.norm(spline(s, 2), axis=1), limits)
    return Ride(spline, s, v, np.concatenate([[0.0], np.cumsum(2.0 * np.diff(s) / (v[1:] + v[:-1]))]))


def profile(s: Array, kappa: Array, limits: Limits) -> Array:
    """The largest speeds (n,) [m/s] at arc lengths s (n,) [m] with curvatures kappa (n,) [1/m]; 0 at both ends."""
    most = np.minimum(limits.speed**2, limits.acceleration / np.maximum(kappa, limits.acceleration / limits.speed**2))
    most[0] = most[-1] = 0.0
    ds, bends = np.diff(s).tolist(), kappa.tolist()
    square = swept(most.tolist(), ds, bends, limits.acceleration)
    square = swept(square[::-1], ds[::-1], bends[::-1], limits.acceleration)[::-1]
    return np.sqrt(square)


def swept(square: list[float], ds: list[float], kappa: list[float], acceleration: float) -> list[float]:
    """Speeds squared `square` (n,) made so small that none is reached from the one before with more acceleration.

    Over a step v^2 rises by 2 ds a_t; a_t^2 + (kappa v^2)^2 <= a_max^2 has to hold where it begins and where it ends.
    """
    found = square.copy()
    for i, step in enumerate(ds):
        before, rise, turn = found[i], 2.0 * step * acceleration, 2.0 * step * kappa[i + 1]
        begin = before + math.sqrt(max(0.0, rise**2 - (2.0 * step * kappa[i] * before) ** 2))
        room = (1.0 + turn**2) * rise**2 - (turn * before) ** 2
        end = (before + math.sqrt(max(0.0, room))) / (1.0 + turn**2)
        found[i + 1] = min(found[i + 1], begin, end)
    return found
