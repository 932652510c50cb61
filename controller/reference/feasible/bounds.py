"""Whether rows keep within limits of speed, acceleration and torque rate: one measure, for the server and the rig."""

import math
from typing import NamedTuple

import numpy as np

from controller.arrays import Array

WINDOW = 0.02
"""Time over which an acceleration is taken [s]: sampling and a camera's noise have none, and a corner a finite one."""
FOREVER = 2**53
"""Ticks of a reference that comes to no end."""
ROUNDED = 1e-6
"""Share by which rounding may exceed a bound."""


class Limits(NamedTuple):
    """What the tip and the torques that hold it may do along a path."""

    speed: float
    """[m/s]."""
    acceleration: float
    """Length of the vector, tangential and centripetal [m/s^2]."""
    torque_rate: float = math.inf
    """Of the torques that hold the points [N m/s]."""

    def scaled(self, factor: float) -> "Limits":
        """All of them times `factor`."""
        return Limits(*(factor * bound for bound in self))


class Excess(NamedTuple):
    """What exceeds its bound the most."""

    field: str
    """Of Limits."""
    row: int
    value: float
    bound: float
    unit: str

    @property
    def share(self) -> float:
        """Of the bound; above 1 it is exceeded."""
        return self.value / self.bound

    def __str__(self) -> str:
        return f"{self.field.replace('_', ' ')} {self.value:.4g} {self.unit}, more than {self.bound:g} {self.unit}"


def standing(p: Array, dt: float) -> Array:
    """Rows p (n, k) with the rest before and after them that an acceleration at their ends needs."""
    return np.pad(p, ((window_rows(dt),) * 2, (0, 0)), "edge")


def window_rows(dt: float) -> int:
    """Rows in half the window of an acceleration."""
    return max(1, round(WINDOW / dt))


def speeds(p: Array, dt: float) -> Array:
    """Speed (n - 1,) [m/s] from each row of p (n, 2) [m] to the next."""
    found: Array = np.hypot(*np.diff(p, axis=0).T) / dt
    return found


def accelerations(p: Array, dt: float) -> Array:
    """|p(t + T) - 2 p(t) + p(t - T)| / T^2 (n - 2 T / dt,) [m/s^2] along rows p (n, 2) [m], T = WINDOW."""
    apart = window_rows(dt)
    change = p[2 * apart :] - 2.0 * p[apart:-apart] + p[: -2 * apart]
    found: Array = np.hypot(*change.T) / (apart * dt) ** 2
    return found


def torque_rates(u: Array, dt: float) -> Array:
    """Rate (n - 1,) [N m/s] of the faster torque from each row of u (n, 2) [N m] to the next."""
    found: Array = np.abs(np.diff(u, axis=0)).max(axis=1, initial=0.0) / dt
    return found


class Measure(NamedTuple):
    """One of Limits along some rows."""

    field: str
    unit: str
    values: Array
    bound: float
    first: int
    """Row of the first value."""


def measures(p: Array, u: Array | None, limits: Limits, dt: float) -> list[Measure]:
    """What rows p (n, 2) [m], held by torques u (n, 2) [N m], ask for."""
    found = [
        Measure("speed", "m/s", speeds(p, dt), limits.speed, 0),
        Measure("acceleration", "m/s^2", accelerations(p, dt), limits.acceleration, window_rows(dt)),
    ]
    if u is not None:
        found.append(Measure("torque_rate", "N m/s", torque_rates(u, dt), limits.torque_rate, 0))
    return found


def worst(p: Array, u: Array | None, limits: Limits, dt: float, steps: tuple[int, ...] = ()) -> Excess | None:
    """What rows p (n, 2) [m], held by torques u (n, 2) [N m], exceed the most; None where they keep within `limits`.

    Steps that begin at the rows `steps` are declared, and exceed nothing.
    """
    found: Excess | None = None
    for field, unit, values, bound, first in measures(p, u, limits, dt):
        for step in steps:
            values[max(0, step - 1 - 2 * first) : step + 1] = 0.0
        row = int(values.argmax()) if len(values) else 0
        share = values[row] / bound if len(values) else 0.0
        if share > (1.0 + ROUNDED if found is None else found.share):
            found = Excess(field, row + first, float(values[row]), bound, unit)
    return found


def exceeding(p: Array, u: Array, limits: Limits, dt: float) -> np.ndarray:
    """Every row (k,) at which rows p (n, 2) [m], held by torques u (n, 2) [N m], exceed a limit."""
    rows = [one.first + np.flatnonzero(one.values > one.bound) for one in measures(p, u, limits, dt)]
    return np.unique(np.concatenate(rows))


def place_of_row(p: Array, row: int, dt: float) -> str:
    """Where and when a row of p (n, 2) [m] is."""
    x, y = 1e3 * p[row]
    return f"at {row * dt:.3f} s, ({x:.1f}, {y:.1f}) mm"


def stretches(n: int, again: int, ticks: int, dt: float) -> list[np.ndarray]:
    """Which of n rows come one after another (k,) when `ticks` are followed, and row `again` comes after the last.

    From rest once through and into the repetition, and to the end and rest. What comes between is the same again.
    """
    pad = window_rows(dt)
    rest, seam = np.zeros(pad, int), 4 * pad
    once = np.arange(min(ticks, n + seam))
    parts = [np.concatenate([rest, once])]
    if ticks <= n + seam:
        parts[0] = np.append(parts[0], np.full(pad, once[-1]))
    elif ticks < FOREVER:
        parts.append(np.minimum(np.arange(ticks - seam, ticks + pad), ticks - 1))
    return [np.where(part < n, part, again + (part - again) % (n - again)) for part in parts]
