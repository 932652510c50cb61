"""The static map and its inverse as a test asks them: each time with scratch of its own."""

from controller.arrays import Array, Pair
from controller.kernels.control import inverse
from controller.kernels.model import sensitivity as slopes
from controller.kernels.model import statics as kernels
from controller.kernels.model.equilibrium import make_scratch
from controller.kernels.model.sensitivity import Expansion
from controller.kernels.model.statics import StaticMap, Statics


def static_tip(statics: Statics, u1: float, u2: float) -> Pair:
    return kernels.static_tip(statics, u1, u2, make_scratch(statics.L.size))


def static_angles(statics: Statics, u1: float, u2: float) -> Array:
    scratch = make_scratch(statics.L.size)
    kernels.static_pose(statics, u1, u2, scratch)
    return scratch.theta


def expand_tip(statics: Statics, u1: float, u2: float) -> Expansion:
    return Expansion(*slopes.expand_tip(statics, u1, u2, make_scratch(statics.L.size)))


def sensitivity(statics: Statics, theta: Array, u: Pair = (0.0, 0.0)) -> tuple[float, float, float, float]:
    return slopes.sensitivity(statics, theta, *u, make_scratch(statics.L.size))


def side_of(statics: Statics, u1: float, u2: float) -> float:
    return slopes.side_of(statics, u1, u2, make_scratch(statics.L.size))


def refine(smap: StaticMap, target: Pair, u: Pair, steps: int) -> tuple[float, float, float, bool]:
    return inverse.refine(smap, target, u, steps, make_scratch(smap.statics.L.size))


def invert(smap: StaticMap, target: Pair, u: Pair, search: bool) -> tuple[float, float, float]:
    return inverse.invert(smap, target, u, search, make_scratch(smap.statics.L.size))
