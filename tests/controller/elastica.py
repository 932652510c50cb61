"""The exact backbone of a planar rod that bends and does nothing else, as an oracle: scipy, and no rod of ours."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from controller.arrays import Array
from controller.schema.actuator import Actuator

TIGHT = {"rtol": 1e-10, "atol": 1e-12}
MOMENTS = (-0.5, 0.5)
"""Between which the weight's moment at the clamp is looked for [N m]."""


def elastica(actuator: Actuator, u: tuple[float, float], arcs: tuple[float, ...]) -> Array:
    """Points (n,2) [m] at `arcs`: EI theta' = u(s) + M, M' = -(t x F), M(L) = 0, under body weight and tip load.

    By shooting at the clamp's moment. u_1 acts on the base half, u_2 on the tip half. EI and mass are even.
    """
    (EI,), length = actuator.EI or (), actuator.length
    gravity, load = np.array(actuator.gravity), actuator.tip_load
    line = actuator.mass / length

    def slope(s: float, z: Array) -> list[float]:
        theta, M = z[2], z[3]
        F = gravity * (load + line * (length - s))
        torque = u[0] if s < length / 2 else u[1]
        c, d = np.cos(theta), np.sin(theta)
        return [c, d, (torque + M) / EI, -(c * F[1] - d * F[0])]

    def shot(M_0: float, at: tuple[float, ...] = ()) -> tuple[float, Array]:
        z, seen = np.array([0.0, 0.0, 0.0, M_0]), []
        for a, b in ((0.0, length / 2), (length / 2, length)):
            inside = [s for s in at if a < s <= b]
            # the jump of u lies between the pieces: no step goes over it
            found = solve_ivp(slope, (a, np.nextafter(b, a)), z, method="DOP853", dense_output=True, **TIGHT)
            seen += [found.sol(min(s, np.nextafter(b, a)))[:2] for s in inside]
            z = found.y[:, -1]
        return float(z[3]), np.array(seen)

    if not gravity.any():
        return shot(0.0, arcs)[1]
    return shot(brentq(lambda M_0: shot(M_0)[0], *MOMENTS, xtol=1e-14), arcs)[1]
