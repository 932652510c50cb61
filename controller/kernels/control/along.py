"""The static inverse along a path, and of many points at once."""

from controller.arrays import Array, Pair
from controller.kernels.compiled import kernel
from controller.kernels.control.inverse import TOLERANCE, refine
from controller.kernels.model.equilibrium import Scratch
from controller.kernels.model.statics import StaticMap, static_tip


@kernel
def invert_along(
    smap: StaticMap,
    p: Array,
    row: int,
    u: Pair,
    every: int,
    steps: int,
    distances: Array,
    scratch: Scratch,
    out_torques: Array,
) -> int:
    """Follow p (n,2) [m] from `row` and u [N m] on: torques (n,2) [N m], and the distances (n,) [m] that they leave.

    Pointwise along the reference: paper, "Quasi-Static Feedforward Control". Ends at the first row where another branch
    should be looked for, or at n: one that is out of reach, and comes after one that is not, or is the next of `every`.
    In place: distances, scratch.
    """
    u1, u2 = u
    for i in range(row, p.shape[0]):
        u1, u2, distances[i], _ = refine(smap, (p[i, 0], p[i, 1]), (u1, u2), steps, scratch)
        out_torques[i, 0], out_torques[i, 1] = u1, u2
        if distances[i] >= TOLERANCE and (i % every == 0 or distances[i - 1] < TOLERANCE):
            return i
    return p.shape[0]


@kernel
def refine_each(smap: StaticMap, steps: int, p: Array, torques: Array, scratch: Scratch) -> None:
    """Refine torques (n,2) [N m], each from itself, until they hold p (n,2) [m].

    A point that is out of the reach of its torques by TOLERANCE or more becomes the tip that they hold.
    Paper, "Quasi-Static Feedforward Control". In place: p, torques, scratch.
    """
    for i in range(p.shape[0]):
        u1, u2, distance, _ = refine(smap, (p[i, 0], p[i, 1]), (torques[i, 0], torques[i, 1]), steps, scratch)
        torques[i, 0], torques[i, 1] = u1, u2
        if distance >= TOLERANCE:
            p[i, 0], p[i, 1] = static_tip(smap.statics, u1, u2, scratch)
