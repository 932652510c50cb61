"""From one pose of the arm to another through u, at the limits: approaches, ways back and detours."""

import math

from controller.errors import ParameterError
from controller.kernels.inverse import StaticMap
from controller.kernels.rod import Array
from controller.reference.approach import blended, blended_torques
from controller.reference.bounds import Limits, standing, worst

Rows = tuple[Array, Array]
"""Places (n, 2) [m] and the torques (n, 2) [N m] that hold them."""
SHORTEST = 0.1
"""No travel takes less time [s]."""
TRIES, SLOWER = 60, 1.05


def travel(smap: StaticMap, u_from: Array, u_to: Array, limits: Limits, dt: float, least: float = SHORTEST) -> Rows:
    """Rows from p(u_from) on towards p(u_to) [m], which would be the next row, and their torques [N m].

    A quintic in u, as `blended`, in `least` [s] or in as much more as `limits` ask for: what lies between two
    admissible torques is admissible, too, and its tip within reach.
    """
    ticks = round(max(least, SHORTEST) / dt)
    for _ in range(TRIES):
        u = blended_torques(u_from, u_to, ticks)
        p = blended(smap, u_from, u_to, ticks)
        excess = worst(standing(p, dt), standing(u, dt), limits, dt)
        if excess is None:
            return p, u
        stretch = math.sqrt(excess.share) if excess.field == "acceleration" else excess.share
        ticks = math.ceil(ticks * max(SLOWER, stretch))
    raise ParameterError(f"no way within limits to another pose of the arm: {excess}")
