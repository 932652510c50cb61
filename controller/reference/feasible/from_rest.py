"""A path that begins at rest, made to leave it on the branch of the static inverse that a reference of ours would take.

At rest the straight arm is on a fold: two poses lead to the same points, and the last digit of a file decides between
them. One of them may need three times the torque further on, or end before the path does.
"""

import numpy as np

from controller.arrays import Array
from controller.kernels.control.inverse import REFINE_STEPS, TOLERANCE
from controller.kernels.model.statics import StaticMap
from controller.reference.feasible.approach import EVERY, follow, solutions
from controller.reference.feasible.reach import static_tips

CLEAR = 0.4
"""Where a path is so far from rest the poses are told apart, as a share of the furthest point that it comes to."""
SAME = 1e-3
"""Torques that differ by less are on one branch [N m]."""
AT_REST = 5e-3
"""A branch leads to rest if it ends with less torque than this [N m]: so flat is the fold."""
LED = (0.05, 0.1, 0.2, 0.3)
"""Share of the way to the clear point on which the path is moved, the least that does."""


def leaving_rest(smap: StaticMap, p: Array) -> Array:
    """The path p (n, 2) [m] from rest on; its first points are moved a little if it would leave on another branch.

    The branch is that of the least torque which carries the path; p itself if none leads back to rest.
    """
    away = np.linalg.norm(p - p[0], axis=1)
    clear = int(np.argmax(away >= CLEAR * away.max()))
    wanted = back_to_rest(smap, p, clear) if clear else None
    if wanted is None or leads_to(smap, p[: clear + 1], wanted[-1]):
        return p
    for share in LED:
        last = int(np.argmax(away >= share * away[clear]))
        led = np.vstack([static_tips(smap, (away[: last + 1] / away[last])[:, None] * wanted[last]), p[last + 1 :]])
        if leads_to(smap, led[: clear + 1], wanted[-1]):
            return led
    return p


def back_to_rest(smap: StaticMap, p: Array, row: int) -> Array | None:
    """Torques (row + 1, 2) [N m] from rest to `row` of p (n, 2) [m] on the branch that carries the path; None without.

    Of several the one of the least torque at `row`; of none the one that carries the path least badly.
    """
    found, least = None, np.inf
    for u in solutions(smap, p[row]):
        torques, distances = follow(smap, p[row::-1], u)
        if distances.max() >= TOLERANCE or np.abs(torques[-1]).max() >= AT_REST:
            continue
        off = float(follow(smap, p[row::EVERY], u)[1].max())
        if off < TOLERANCE:
            return torques[::-1]
        if off < least:
            found, least = torques[::-1], off
    return found


def leads_to(smap: StaticMap, p: Array, u: Array) -> bool:
    """Whether the tick's inverse, which follows p (n, 2) [m] from rest, ends at the torques u (2,) [N m]."""
    return bool(np.abs(follow(smap, p, np.zeros(2), REFINE_STEPS)[0][-1] - u).max() < SAME)
