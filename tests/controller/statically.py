"""The static map and its inverse as a test asks them: each time with scratch of its own."""

from controller.arrays import Array, Pair
from controller.kernels.control import inverse
from controller.kernels.model import statics as kernels
from controller.kernels.model.equilibrium import make_scratch
from controller.kernels.model.statics import Expansion, StaticMap, Statics


def static_tip(statics: Statics, u1: float, u2: float) -> Pair:
    return kernels.static_tip(statics, u1, u2, make_scratch(statics.L.size))


def static_angles(statics: Statics, u1: float, u2: float) -> Array:
    scratch = make_scratch(statics.L.size)
    kernels.static_pose(statics, u1, u2, scratch)
    return scratch.theta


def expand_tip(statics: Statics, u1: float, u2: float) -> Expansion:
    return Expansion(*kernels.expand_tip(statics, u1, u2, make_scratch(statics.L.size)))


def sensitivity(statics: Statics, theta: Array) -> tuple[float, float, float, float]:
    return kernels.sensitivity(statics, theta, make_scratch(statics.L.size))


def side_of(statics: Statics, u1: float, u2: float) -> float:
    return kernels.side_of(statics, u1, u2, make_scratch(statics.L.size))


def refine(smap: StaticMap, target: Pair, u: Pair, steps: int) -> tuple[float, float, float, bool]:
    return inverse.refine(smap, target, u, steps, make_scratch(smap.statics.L.size))


def invert(smap: StaticMap, target: Pair, u: Pair, search: bool) -> tuple[float, float, float]:
    return inverse.invert(smap, target, u, search, make_scratch(smap.statics.L.size))
