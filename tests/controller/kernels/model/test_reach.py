"""The map of the reach, against the model's own limits and against brute force."""

import numpy as np
import pytest

from controller.assembly.rod import build_rod
from controller.assembly.statics import static_map
from controller.reference.feasible.reach import reach_map, static_tips
from controller.schema.actuator import PRESETS
from controller.schema.parameters import ControllerParameters, RigParameters

pytestmark = pytest.mark.keyed()


@pytest.mark.parametrize("name", PRESETS)
def test_the_map_covers_exactly_the_admissible_torques(name: str) -> None:
    actuator = PRESETS[name]
    reach = reach_map(RigParameters(actuator=actuator))
    bend = build_rod(actuator, 10).compliance[-1]
    assert np.abs(reach.u).max() == pytest.approx(actuator.u_max)
    assert np.abs(reach.u @ bend).max() <= actuator.bend_max * (1 + 1e-9)
    rng = np.random.default_rng(1)
    u = rng.uniform(-actuator.u_max, actuator.u_max, (2000, 2))
    inside = u[np.abs(u @ bend) <= actuator.bend_max]
    share = np.ptp(reach.u[:, [0, -1], 1], axis=1)
    area = np.trapezoid(share, reach.u[:, 0, 0])
    assert area == pytest.approx(len(inside) / len(u) * (2 * actuator.u_max) ** 2, rel=0.05)


def test_every_reachable_tip_lies_beside_a_point_of_the_map() -> None:
    reach = reach_map(RigParameters())
    smap = static_map(PRESETS["P1"], ControllerParameters())
    rng = np.random.default_rng(2)
    u = rng.uniform(-0.06, 0.06, (200, 2))
    u = u[np.abs(u @ smap.statics.compliance[-1]) <= PRESETS["P1"].bend_max]
    tips = static_tips(smap, u)
    apart = np.linalg.norm(tips[:, None] - reach.p.reshape(1, -1, 2), axis=-1).min(axis=1)
    assert apart.max() < 8e-3


def test_the_workspace_of_p1_has_its_hole_on_the_rest_axis() -> None:
    p = reach_map(RigParameters()).p.reshape(-1, 2)
    for x in (0.0, 0.04, 0.08):
        assert np.linalg.norm(p - [x, 0.0], axis=1).min() > 20e-3
    assert np.linalg.norm(p - [0.253, 0.0], axis=1).min() < 2e-3
    assert np.linalg.norm(p - [0.0, 0.14], axis=1).min() < 6e-3
