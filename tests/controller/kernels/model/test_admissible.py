"""Admissible torques where gravity makes two poses of some: none of these is let in."""

from typing import Any

import numpy as np
import pytest

from controller.arrays import Array
from controller.assembly.poses import two_poses
from controller.assembly.statics import static_map
from controller.kernels.model.equilibrium import equilibrium, make_scratch
from controller.kernels.model.polygon import admissible, nearest_admissible
from controller.kernels.model.statics import StaticMap
from controller.reference.feasible.reach import extent, span
from controller.schema.actuator import PRESETS
from controller.schema.parameters import ControllerParameters
from tests.controller.statically import static_angles

pytestmark = pytest.mark.keyed()

BODIES: dict[str, dict[str, Any]] = {
    "P2 lying": {"gravity": (0.0, -4.0)},
    "P2 hanging": {"gravity": (4.0, 0.0)},
    "P1 hanging, loaded": {"gravity": (4.0, 0.0), "tip_load": 0.004},
    "P3 lying, bent at rest": {"gravity": (0.0, -9.81), "rest_curvature": (2.0,)},
}
LEGS = 24
"""Of a way of the torques; each is short against the part of the reach that one pose holds."""


def map_of(body: str) -> StaticMap:
    return static_map(PRESETS[body[:2]].model_copy(update=BODIES[body]), ControllerParameters())


def led(smap: StaticMap, theta: Array, begin: Array, end: Array) -> Array:
    """The pose that follows from `theta` as the torques go straight from `begin` to `end`."""
    scratch = make_scratch(theta.size)
    scratch.theta[:] = theta
    for share in np.arange(1, LEGS + 1) / LEGS:
        equilibrium(smap.statics.body, *(begin + share * (end - begin)), scratch)
    return scratch.theta


@pytest.mark.parametrize("body", BODIES)
def test_whichever_way_torques_went_before_an_admissible_pair_ends_in_the_pose_of_the_map(body: str) -> None:
    smap, random = map_of(body), np.random.default_rng(0)
    u_max = smap.polygon.bounds[0]
    assert two_poses(smap.statics).any()
    for _ in range(40):
        u, theta = np.zeros(2), smap.statics.rest
        for goal in random.uniform(-u_max, u_max, (4, 2)):
            theta, u = led(smap, theta, u, goal), goal
        home = smap.seeds[random.integers(len(smap.seeds))]
        assert led(smap, theta, u, home) == pytest.approx(static_angles(smap.statics, *home), abs=0.05)


@pytest.mark.parametrize("body", BODIES)
def test_the_polygon_is_convex_holds_the_rest_and_keeps_to_the_bend_limit(body: str) -> None:
    smap = map_of(body)
    polygon, actuator = smap.polygon, PRESETS[body[:2]]
    assert (polygon.bounds > 0.0).all() and polygon.bounds[0] == actuator.u_max
    edges = np.roll(polygon.corners, -1, axis=0) - polygon.corners
    after = np.roll(edges, -1, axis=0)
    assert (edges[:, 0] * after[:, 1] - edges[:, 1] * after[:, 0] > 0.0).all()
    for u in smap.seeds:
        assert abs(static_angles(smap.statics, *u)[-1] - smap.statics.rest[-1]) <= actuator.bend_max


@pytest.mark.parametrize("body", BODIES)
def test_what_is_beyond_it_is_brought_to_its_edge_and_columns_end_there(body: str) -> None:
    polygon = map_of(body).polygon
    for u in np.random.default_rng(1).uniform(-0.2, 0.2, (50, 2)):
        assert admissible(polygon, *nearest_admissible(polygon, *u))
    u_1 = np.linspace(*extent(polygon), 31)[1:-1]
    low, high = span(polygon, u_1)
    for one, below, above in zip(u_1, low, high, strict=True):
        assert admissible(polygon, one, below) and admissible(polygon, one, above)
        assert not admissible(polygon, one, below - 1e-6) and not admissible(polygon, one, above + 1e-6)
