"""The static map against finite differences, an elastica and the resting chain."""

import numpy as np
import pytest

from controller.assembly.rod import build_rod
from controller.assembly.statics import build_static_map
from controller.kernels.model.statics import places, points_on
from controller.schema.actuator import PRESETS
from controller.schema.parameters import ControllerParameters
from tests.controller.chains import posed, preset, static
from tests.controller.statically import expand_tip, sensitivity, static_tip

pytestmark = pytest.mark.keyed()

TORQUES = [(0.0, 0.0), (0.02, -0.01), (-0.03, 0.04), (0.05, 0.01)]


@pytest.mark.parametrize("name", PRESETS)
@pytest.mark.parametrize("u", TORQUES)
def test_the_sensitivity_is_the_slope_of_the_static_tip(name: str, u: tuple[float, float]) -> None:
    model, h = preset(name), 1e-6
    S = np.array(sensitivity(static(model), model.compliance @ u)).reshape(2, 2)
    for j in range(2):
        step = h * np.eye(2)[j]
        slope = np.subtract(static_tip(static(model), *(u + step)), static_tip(static(model), *(u - step))) / (2 * h)
        assert S[:, j] == pytest.approx(slope, abs=1e-7)


@pytest.mark.parametrize("u", TORQUES)
def test_the_expansion_holds_the_slope_and_the_curvature_of_the_tip(u: tuple[float, float]) -> None:
    statics, h = static(preset("P2")), 1e-5
    at = expand_tip(statics, *u)
    assert static_tip(statics, *u) == pytest.approx((at.x, at.y), abs=1e-15)
    first, second = np.array([h, 0.0]), np.array([0.0, h])
    ahead, behind = (
        expand_tip(statics, *(u + first)),
        expand_tip(statics, *(u - first)),
    )
    assert (ahead.x_1 - behind.x_1) / (2 * h) == pytest.approx(at.x_11, rel=1e-5, abs=1e-4)
    assert (ahead.y_2 - behind.y_2) / (2 * h) == pytest.approx(at.y_12, rel=1e-5, abs=1e-4)
    ahead, behind = (
        expand_tip(statics, *(u + second)),
        expand_tip(statics, *(u - second)),
    )
    assert (ahead.y_2 - behind.y_2) / (2 * h) == pytest.approx(at.y_22, rel=1e-5, abs=1e-4)
    assert (ahead.x_1 - behind.x_1) / (2 * h) == pytest.approx(at.x_12, rel=1e-5, abs=1e-4)


def test_a_torque_at_the_tip_bends_a_fine_chain_to_a_circle() -> None:
    """From the clamp, which gives way like half a rod of ten, to the middle of the tenth; beyond it is straight."""
    u, EI, L = 0.03, 0.0751 * 0.253 / 10, 0.253
    base, bend = u * L / 20 / EI, u * 0.95 * L / EI
    end = base + bend
    x = EI / u * (np.sin(end) - np.sin(base)) + L / 20 * np.cos(end)
    y = EI / u * (np.cos(base) - np.cos(end)) + L / 20 * np.sin(end)
    assert static_tip(static(build_rod(PRESETS["P1"], 1000)), u, u) == pytest.approx((x, y), abs=2e-4)


@pytest.mark.parametrize("rods", [7, 10, 20, 33])
def test_a_sensor_is_the_same_point_of_the_body_for_every_number_of_rods(rods: int) -> None:
    length = 0.253
    arc = length * np.arange(1, 11) / 10
    at = places(preset(rods=rods), arc)
    bend = 4.0
    theta = bend * (np.arange(rods) + 0.5) / rods
    points = np.zeros((10, 2))
    points_on(posed(preset(rods=rods), theta, np.zeros(rods)).q, at, points)
    s = bend * arc / length
    circle = length / bend * np.column_stack([np.sin(s), 1 - np.cos(s)])
    assert points == pytest.approx(circle, abs=bend * length / rods / 8)
    assert at.rod[-1] == rods - 1


def test_the_polygon_is_the_box_cut_by_the_bend_limit() -> None:
    actuator = PRESETS["P1"]
    polygon = build_static_map(preset(), actuator, ControllerParameters()).polygon
    assert len(polygon.corners) == 6
    assert np.abs(polygon.corners).max() == pytest.approx(actuator.u_max)
    assert np.abs(polygon.corners @ preset().compliance[-1]).max() == pytest.approx(actuator.bend_max)
