"""The static map and its inverse as a test asks them: each time with scratch of its own."""

import numpy as np
import pytest

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


def require_slopes(statics: Statics, u: Array, h: float = 1e-5) -> None:
    """S and curvature at u (2,) [N m] are the differences of the tip and of S over 2 h."""
    at = expand_tip(statics, *u)
    S = np.array(sensitivity(statics, static_angles(statics, *u), (u[0], u[1]))).reshape(2, 2)
    assert S.ravel() == pytest.approx(at[2:6], rel=1e-9)
    for j, step in enumerate(h * np.eye(2)):
        ahead, behind = (np.array(static_tip(statics, *(u + sign * step))) for sign in (1, -1))
        assert S[:, j] == pytest.approx((ahead - behind) / (2 * h), abs=1e-4)
        more, less = (expand_tip(statics, *(u + sign * step)) for sign in (1, -1))
        change = np.array(more[2:6]) - np.array(less[2:6])
        curved = (at.x_11, at.x_12, at.y_11, at.y_12) if j == 0 else (at.x_12, at.x_22, at.y_12, at.y_22)
        assert change / (2 * h) == pytest.approx(curved, rel=1e-3, abs=0.5)
