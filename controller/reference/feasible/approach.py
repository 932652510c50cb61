"""From rest to the first point of a shape, and along it, on one branch of the static inverse."""

import numpy as np

from controller.arrays import Array
from controller.assembly.statics import scratch_for
from controller.errors import ParameterError
from controller.kernels.control.inverse import TOLERANCE, refine
from controller.kernels.model.statics import StaticMap
from controller.reference.feasible.reach import static_tips

NEAR_SEEDS, SETTLE_STEPS = 60, 30
APART = 1e-4
"""Torques that differ by less are one solution [N m]."""
EVERY = 20
"""Rows from one look at the path to the next when a branch is chosen."""


def approach(smap: StaticMap, u: Array, ticks: int) -> Array:
    """Tips (ticks, 2) [m] from rest towards p(u), which would be the next row; u (2,) [N m]."""
    return blended(smap, np.zeros(2), u, ticks)


def blended(smap: StaticMap, u_from: Array, u_to: Array, ticks: int) -> Array:
    """Tips (ticks, 2) [m] from p(u_from) on towards p(u_to), which would be the next row; torques (2,) [N m].

    Blended in u by a quintic, at rest at both ends: a blend in p would leave the reach.
    """
    return static_tips(smap, blended_torques(u_from, u_to, ticks))


def blended_torques(u_from: Array, u_to: Array, ticks: int) -> Array:
    """The torques (ticks, 2) [N m] that hold the tips of `blended`."""
    found: Array = u_from + quintic(ticks) * (u_to - u_from)
    return found


def quintic(ticks: int) -> Array:
    """Shares (ticks, 1) of a quintic that rests at 0 and at the 1 that would be the next."""
    s = np.arange(ticks)[:, None] / ticks
    found: Array = s**3 * (10.0 - 15.0 * s + 6.0 * s * s)
    return found


def branch(smap: StaticMap, p: Array) -> Array:
    """Torques u (2,) [N m] at the first row of p (n, 2) [m] from which one branch carries the whole path.

    Of several the least torque, which is the nearest to rest. Raises ParameterError where there is none.
    """
    starts = solutions(smap, p[0])
    if not starts:
        raise ParameterError(f"p[0] = ({p[0, 0]:.4f}, {p[0, 1]:.4f}) m is out of reach")
    left = []
    for u in starts:
        left.append(float(follow(smap, p[::EVERY], u)[1].max()))
        if left[-1] < TOLERANCE:
            return u
    raise ParameterError(f"the path leaves the reach by {1e3 * min(left):.1f} mm")


def solutions(smap: StaticMap, p: Array) -> list[Array]:
    """All torques (2,) [N m] that hold the tip at p (2,) [m], the least first."""
    found: list[Array] = []
    scratch = scratch_for(smap)
    for k in np.argsort(np.linalg.norm(smap.seed_tips - p, axis=1))[:NEAR_SEEDS]:
        u1, u2, distance, _ = refine(smap, (p[0], p[1]), (smap.seeds[k, 0], smap.seeds[k, 1]), SETTLE_STEPS, scratch)
        u = np.array([u1, u2])
        if distance < TOLERANCE and all(np.abs(u - other).max() > APART for other in found):
            found.append(u)
    return sorted(found, key=lambda u: float(np.abs(u).max()))


def follow(smap: StaticMap, p: Array, u: Array, steps: int = SETTLE_STEPS) -> tuple[Array, Array]:
    """Torques (n, 2) [N m] along p (n, 2) [m], each refined from the one before, and the distances (n,) they leave."""
    torques, distances, scratch = np.empty_like(p), np.empty(len(p)), scratch_for(smap)
    u1, u2 = u
    for i, (x, y) in enumerate(p):
        u1, u2, distances[i], _ = refine(smap, (x, y), (u1, u2), steps, scratch)
        torques[i] = u1, u2
    return torques, distances
