"""Friction that sticks: on the sheet under the rods, and inside the material (hysteresis).

Not in the paper: flaws of the twin. Both are Dahl's law: an elastic deflection that follows the motion and ends at a
bound, which no rate has a part in. Unlike Coulomb friction regularised by a speed it holds for ever, and a small motion
back and forth is elastic.
"""

import math

from controller.arrays import Array
from controller.kernels.compiled import inlined, kernel
from controller.kernels.group import Group
from controller.kernels.model.rod import RodModel

GRAVITY = 9.81
"""Presses the rods on the sheet [m/s^2]."""


class Sheet(Group):
    """The sheet on which the rods slide."""

    friction: float
    """Coulomb coefficient [1]."""
    slip: float
    """Way over which the friction builds up [m]."""
    deflection: Array
    """(2,N) share of the greatest friction that each rod feels, against its motion; length at most 1."""


class Hysteresis(Group):
    """A slider with a spring in series, beside every hinge's spring."""

    share: float
    """Stiffness of it for small motions over the hinge's."""
    bend: float
    """Change of a hinge's bend over which it builds up [rad]."""
    deflection: Array
    """(N,) share of its greatest torque, -1..1."""
    last: Array
    """(N,) bend at the last step [rad]."""


@inlined
def dahl(z: float, way: float, keep: float) -> float:
    """Deflection z (-1..1) after a motion in the direction `way` (of length 1) that lets `keep` of the old one be.

    dz/ds = (way - z) / bound along the path s, solved exactly: keep = exp(-|ds| / bound). Not in the paper: Dahl 1968.
    """
    return way + (z - way) * keep


@kernel
def rub(m: Array, v: Array, h: float, sheet: Sheet, out_F: Array) -> None:
    """Friction (2,N) [N] of the masses m (N,) [kg] against the sheet; the deflections follow v (3,N) for h [s].

    Not in the paper, which only names the sheet ("Hardware setup"). In place: sheet.deflection.
    """
    for i in range(out_F.shape[1]):
        z, speed = sheet.deflection, math.hypot(v[0, i], v[1, i])
        if speed > 0.0:
            keep = math.exp(-speed * h / sheet.slip)
            z[0, i] = dahl(z[0, i], v[0, i] / speed, keep)
            z[1, i] = dahl(z[1, i], v[1, i] / speed, keep)
        drag = sheet.friction * m[i] * GRAVITY
        out_F[0, i] = -drag * z[0, i]
        out_F[1, i] = -drag * z[1, i]


@kernel
def resist_hysteresis(model: RodModel, q: Array, hysteresis: Hysteresis, Q_theta: Array) -> None:
    """Torques of the sliders in the hinges; they follow the bend of q (3,N).

    Not in the paper: a flaw of the twin. In place: hysteresis, Q_theta (N,) [N m], to which they are added.
    """
    greatest = hysteresis.share * hysteresis.bend
    for i in range(Q_theta.size):
        bend = q[2, i] - q[2, i - 1] if i > 0 else q[2, 0]
        moved = bend - hysteresis.last[i]
        hysteresis.last[i] = bend
        keep = math.exp(-abs(moved) / hysteresis.bend)
        hysteresis.deflection[i] = dahl(hysteresis.deflection[i], math.copysign(1.0, moved), keep)
        torque = greatest * model.k[i] * hysteresis.deflection[i]
        Q_theta[i] -= torque
        if i > 0:
            Q_theta[i - 1] += torque
