"""A feedforward that adapts to the arm: how far it brings one that is another, and what it never does."""

import math

import numpy as np
import pytest

from controller.arrays import Rows
from controller.assembly.controllers.registry import with_controller
from controller.kernels.control.adaptive import LEAD_MOST
from controller.reference.library import reference
from controller.research.experiments.plant_scale import scaled
from controller.schema.actuator import PRESETS
from controller.schema.modes import Mode, Request
from controller.schema.parameters import (
    REPEATING,
    ControllerParameters,
    RigParameters,
    Settings,
    TwinParameters,
    usual_twin,
)
from controller.simulation.metrics import Window, measure, rmse, true_tip
from controller.simulation.run import attempt
from tests.controller.trial import Trial, twin_with

pytestmark = pytest.mark.keyed()

CONTROLLER = ControllerParameters()
OTHERS = ("k=0.8", "k=1.2", "torque=0.8", "torque=1.2", "delay=0.02", "friction=2", "zeta=0.4", "noise=2")
"""Arms that are not the model's, as `--plant-scale` has them."""


def rows_of(
    name: str, controller: str, plant: str = "", actuator: str = "P1", kind: str = "rod", **tuning: float
) -> Rows:
    """Telemetry of a run; every row is in TRACK."""
    body = PRESETS[actuator]
    twin = scaled(usual_twin(body, TwinParameters(plant=kind)), plant, body)
    parameters = RigParameters(actuator=body, controller=CONTROLLER, twin=twin)
    settings = with_controller(REPEATING, controller, tuning)
    rows = attempt(parameters, reference(name, body, CONTROLLER), settings, 0)
    assert (rows["mode"] == Mode.TRACK).all(), "stopped"
    return rows


def error_of(name: str, rows: Rows, actuator: str = "P1") -> float:
    """RMSE after the approach [mm]."""
    return measure(rows, reference(name, PRESETS[actuator], CONTROLLER), Window.AFTER_APPROACH)["rmse"]


@pytest.mark.parametrize("plant", ["k=0.8", "k=1.2", "torque=0.8", "torque=1.2"])
def test_a_softer_or_stiffer_arm_is_within_6_mm_on_the_1_hz_circle_within_ten_seconds(plant: str) -> None:
    """What the issue of this step asks for; without it 6.5 to 8.5 mm."""
    path = reference("circle_1hz", PRESETS["P1"], CONTROLLER)
    e = path.p - true_tip(rows_of("circle_1hz", "adaptive", plant))
    assert 1e3 * rmse(e[path.start :]) < 6.0
    assert 1e3 * rmse(e[-2000:]) < 5.5


@pytest.mark.parametrize("plant", OTHERS)
@pytest.mark.parametrize(
    ("name", "actuator"), [("vu", "P1"), ("digit_8", "P2"), ("vertical_1hz", "P1"), ("circle_0.25hz", "P3")]
)
def test_no_arm_is_followed_worse_than_without_and_others_much_better(name: str, actuator: str, plant: str) -> None:
    without, adapted = (
        error_of(name, rows_of(name, controller, plant, actuator), actuator) for controller in ("preview", "adaptive")
    )
    stiffness = plant.startswith(("k", "torque"))
    assert adapted < (0.95 if stiffness else 1.15) * without


@pytest.mark.parametrize(
    ("plant", "sigma"), [("k=0.8", -0.2), ("k=1.2", 0.2), ("torque=0.8", 0.25), ("torque=1.2", -0.17)]
)
def test_it_finds_how_stiff_the_arm_is(plant: str, sigma: float) -> None:
    """Beside what the twin's own chambers and gain are off by, which `twin` shows."""
    nominal, found = (np.mean(rows_of("circle_0.25hz", "adaptive", one)["signals"][-4000:, 4:6]) for one in ("", plant))
    assert found - nominal == pytest.approx(sigma, abs=0.08)


def test_a_plant_of_another_kind_is_followed_better_too() -> None:
    for name in ("vu", "circle_1hz"):
        without, adapted = (error_of(name, rows_of(name, one, kind="cosserat")) for one in ("preview", "adaptive"))
        assert adapted < 0.75 * without


def test_frozen_it_is_preview_to_the_last_bit() -> None:
    frozen, plain = rows_of("digit_8", "adaptive", "k=0.8", rate=0.0), rows_of("digit_8", "preview", "k=0.8")
    assert np.array_equal(frozen["u"], plain["u"]) and not frozen["signals"][:, 4:].any()


def test_it_stays_within_its_bounds() -> None:
    rows = rows_of("circle_1hz", "adaptive", "k=0.5", most=0.1)
    assert np.abs(rows["signals"][:, 4:6]).max() == pytest.approx(0.1)
    assert np.abs(rows["signals"][:, 6:8]).max() <= LEAD_MOST


def test_it_does_not_wander_at_rest() -> None:
    """A minute in HOLD, far from rest, on an arm that creeps: what stands still is the integral's matter."""
    settings = with_controller(Settings(), "adaptive").model_dump()
    trial = Trial(parameters=twin_with(stiffness_scale=0.8), **settings)
    trial.arm()
    moved = trial.follow(0.10, 0.14, 4.0)["signals"][-1, 4:8]
    assert np.abs(moved).max() > 0.02, "it has learned something"
    held = trial.ask(Request.HOLD, ticks=60_000)["signals"][:, 4:8]
    assert np.abs(held - held[0]).max() < 0.02
    assert np.abs(held[-1] - held[len(held) // 2]).max() < 0.002


def test_without_the_tips_own_marker_nothing_is_learned() -> None:
    body = PRESETS["P1"]
    parameters = RigParameters(actuator=body, controller=CONTROLLER, twin=scaled(usual_twin(body), "k=0.8", body))
    settings = with_controller(REPEATING, "adaptive").model_copy(update={"sensed": 1 << 5})
    rows = attempt(parameters, reference("vu", body, CONTROLLER), settings, 0)
    assert not rows["signals"][:, 4:].any() and math.isfinite(float(rows["u"].sum()))
