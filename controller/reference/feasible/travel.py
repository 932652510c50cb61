"""From one pose of the arm to another through u, at the limits: approaches, ways back and detours."""

import math
from typing import NamedTuple

import numpy as np

from controller.arrays import Array
from controller.errors import ParameterError
from controller.kernels.model.statics import StaticMap
from controller.reference.feasible.approach import blended_torques, quintic
from controller.reference.feasible.bounds import Limits, standing, window_rows, worst
from controller.reference.feasible.reach import static_tips

PointsAndTorques = tuple[Array, Array]
"""Places (n, 2) [m] and the torques (n, 2) [N m] that hold them."""
TRAVEL_MIN_S = 0.1
"""No travel takes less time [s]."""
ROUNDS_MAX, SLOWER = 60, 1.05
EASE, SAME = 0.1, 1e-7
"""Time in which the tip is moved from a row to where its torques hold it [s], where these are further apart [m]."""


class Pose(NamedTuple):
    """Where a travel begins or ends."""

    p: Array
    """(2,) [m]: the row that it joins, which its torques hold to within a tolerance only."""
    u: Array
    """(2,) [N m]."""


def rest(smap: StaticMap) -> Pose:
    """The straight arm."""
    return held_by(smap, np.zeros(2))


def held_by(smap: StaticMap, u: Array) -> Pose:
    """The pose that the torques u (2,) [N m] hold."""
    return Pose(static_tips(smap, u[None])[0], u)


def travel(
    smap: StaticMap, start: Pose, end: Pose, limits: Limits, dt: float, least: float = TRAVEL_MIN_S
) -> PointsAndTorques:
    """Rows from `start` on towards `end`, which would be the next row, and their torques [N m].

    A quintic in u, as `blended`, in `least` [s] or in as much more as `limits` ask for: what lies between two
    admissible torques is admissible, too, and its tip within reach.
    """
    ticks = round(max(least, TRAVEL_MIN_S) / dt) - 2 * window_rows(dt)
    for _ in range(ROUNDS_MAX):
        u = blended_torques(start.u, end.u, ticks)
        p, u = joined(start, (static_tips(smap, u), u), end, dt)
        excess = worst(standing(p, dt), standing(u, dt), limits, dt)
        if excess is None:
            return p, u
        stretch = math.sqrt(excess.share) if excess.field == "acceleration" else excess.share
        ticks = math.ceil(ticks * max(SLOWER, stretch))
    raise ParameterError(f"no way within limits to another pose of the arm: {excess}")


def joined(start: Pose, rows: PointsAndTorques, end: Pose, dt: float) -> PointsAndTorques:
    """`rows`, and those that lead from `start` to their first and from their last to `end`, standing still at both.

    A row's place may be off the tip that its torques hold by a tolerance that, in one tick, would exceed every limit.
    """
    parts = [eased(start.p, rows[0][0], start.u, dt), rows, eased(rows[0][-1], end.p, end.u, dt)]
    return np.vstack([p for p, _ in parts]), np.vstack([u for _, u in parts])


def eased(p_from: Array, p_to: Array, u: Array, dt: float) -> PointsAndTorques:
    """Rows from p_from (2,) on towards p_to (2,) [m], both held by u (2,) [N m], with a rest before and after."""
    still = np.zeros((window_rows(dt), 1))  # else one acceleration would be taken over both what ends and what begins
    apart = np.linalg.norm(p_to - p_from) >= SAME
    share = np.vstack([still, quintic(round(EASE / dt)), 1.0 + still]) if apart else still
    return p_from + share * (p_to - p_from), np.tile(u, (len(share), 1))
