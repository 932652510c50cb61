"""Torques that move the nominal model along a reference."""

import numpy as np
import pytest

from controller.assembly.statics import static_map
from controller.reference.feasible.reach import static_tips
from controller.reference.library import reference
from controller.reference.torques import foreseen, planned_torques
from controller.schema.actuator import PRESETS
from controller.schema.parameters import ControllerParameters

pytestmark = pytest.mark.keyed()

CONTROLLER = ControllerParameters(observer_kappa=39.93)
HANGING = PRESETS["P1"].model_copy(update={"name": "hanging", "gravity": (9.81, 0.0)})


def rms(e: np.ndarray) -> float:
    """Of the length of e (n,2) [mm]."""
    return 1e3 * float(np.sqrt((e**2).sum(axis=1).mean()))


@pytest.mark.parametrize(
    ("name", "actuator", "most"),
    [("circle_1hz", "P1", 2.0), ("vu", "P1", 0.2), ("digit_8", "P1", 0.5), ("circle_2hz", "P3", 0.5)],
)
def test_the_model_follows_its_plan(name: str, actuator: str, most: float) -> None:
    body = PRESETS[actuator]
    p = reference(name, body, CONTROLLER).p
    u = planned_torques(body, CONTROLLER, p, None)
    assert rms(p - foreseen(body, CONTROLLER, u)) < most
    polygon = static_map(body, CONTROLLER).polygon
    assert ((u @ polygon.normals.T) <= polygon.bounds * (1 + 1e-9)).all()


def test_it_begins_and_ends_with_the_torques_that_hold_the_tip() -> None:
    body = PRESETS["P1"]
    smap = static_map(body, CONTROLLER)
    p = reference("vu", body, CONTROLLER).p
    u = planned_torques(body, CONTROLLER, np.vstack([p, np.tile(p[-1], (2000, 1))]), None)
    tips = static_tips(smap, u[[0, -1]])
    assert rms(tips - p[[0, -1]]) < 0.5
    assert np.abs(np.diff(u[-500:], axis=0)).max() < 1e-6


def test_what_stands_still_is_held() -> None:
    body = PRESETS["P2"]
    held = np.tile([0.02, -0.01], (1500, 1))
    p = static_tips(static_map(body, CONTROLLER), held)
    assert planned_torques(body, CONTROLLER, p, held) == pytest.approx(held, abs=1e-6)


def test_an_arm_that_hangs_is_planned_with_its_weight() -> None:
    smap = static_map(HANGING, CONTROLLER)
    t = np.linspace(0.0, 1.0, 3000)
    held = np.outer(np.sin(np.pi * t) ** 2, [0.3, -0.2]) * HANGING.u_max
    p = static_tips(smap, held)
    u = planned_torques(HANGING, CONTROLLER, p, held)
    assert rms(p - foreseen(HANGING, CONTROLLER, u)) < 0.2 * rms(p - foreseen(HANGING, CONTROLLER, held))
