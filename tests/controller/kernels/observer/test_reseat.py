"""An observer that a whip has wound is found out and set again; one that is right, or merely off, is left alone."""

from typing import Any

import numpy as np
import pytest

from controller.kernels.model.statics import pose
from controller.schema.actuator import PRESETS
from controller.schema.modes import Mode, Request
from controller.schema.parameters import RigParameters, TwinParameters
from tests.controller.trial import Trial, distance

TIP, ROD_6, ALL = 1 << 9, 1 << 5, (1 << 10) - 1
POINTS = {"P1": (0.15, 0.05), "P2": (0.15, 0.05), "P3": (0.10, 0.05)}
HANGING = PRESETS["P1"].model_copy(update={"gravity": (9.81, 0.0), "tip_load": 0.01})


def bent(name: str, parameters: RigParameters | None = None, **settings: Any) -> Trial:
    """An arm that stands bent, in HOLD."""
    trial = Trial(name, parameters, **settings)
    trial.arm()
    trial.follow(*POINTS[name], 2.5)
    trial.ask(Request.HOLD, ticks=200)
    return trial


def wind(trial: Trial, turn: float) -> None:
    """Wind the model's angles by `turn` [rad] in all, evenly along the arm."""
    q = trial.rig.observer.state.q
    rods = q.shape[1]
    pose(trial.rig.observer.model, q[2] + turn * np.arange(1, rods + 1) / rods, q)


@pytest.mark.parametrize("sensed", [TIP, TIP | ROD_6], ids=["tip", "tip and rod 6"])
@pytest.mark.parametrize("name", PRESETS)
def test_a_wound_observer_begins_again_from_the_pose_of_the_arm(name: str, sensed: int) -> None:
    trial = bent(name, sensed=sensed)
    right = float(trial.rig.observer.state.q[2, -1])
    wind(trial, -2 * np.pi)
    rows = trial.run(3000)
    last = rows[-1]
    assert last["reseats"] == 1 and last["mode"] == Mode.HOLD
    assert abs(trial.rig.observer.state.q[2, -1] - right) < 0.05
    assert last["residual"] < 2e-3 and distance(last["backbone"], last["twin_backbone"]).max() < 10e-3
    assert rows["reseats"][-1] == np.diff(rows["reseats"]).sum(), "counted once, and from 0 on"


def test_it_is_moved_over_smoothly_and_nothing_is_fed_back_meanwhile() -> None:
    trial = bent("P1", sensed=TIP | ROD_6)
    wind(trial, -2 * np.pi)
    rows = trial.run(3000)
    end = int(np.flatnonzero(np.diff(rows["reseats"]))[0])
    moved = rows[end - 195 : end]
    assert not moved["sensed"].any() and rows["sensed"][end + 5]
    assert distance(moved["p_hat"][1:], moved["p_hat"][:-1]).max() < 10e-3, "no jump of the shown arm"
    assert abs(np.diff(moved["u"], axis=0)).max() < 2e-3, "nor of the torques"


def test_a_vented_arm_with_a_wound_observer_is_mended_too() -> None:
    trial = Trial("P2")
    trial.run(100)
    wind(trial, -2 * np.pi)
    rows = trial.run(3000)
    assert rows["mode"][-1] == Mode.VENTED
    assert abs(trial.rig.observer.state.q[2, -1]) < 0.3 and rows["residual"][-1] < 2e-3


def test_under_gravity_too() -> None:
    trial = bent("P1", RigParameters(actuator=HANGING), sensed=TIP | ROD_6)
    right = float(trial.rig.observer.state.q[2, -1])
    wind(trial, -2 * np.pi)
    trial.run(3000)
    assert abs(trial.rig.observer.state.q[2, -1] - right) < 0.1


@pytest.mark.parametrize("sensed", [TIP, ROD_6, ALL])
def test_an_observer_that_is_merely_off_is_left_alone(sensed: int) -> None:
    """A plant with a third less torque and a curvature at rest, and markers that are 60 mm beside the arm."""
    twin = TwinParameters(torque_gain=(0.7, 0.7), set_curvature=(2.0, 2.0))
    trial = bent("P1", RigParameters(actuator=PRESETS["P1"], twin=twin), sensed=sensed)
    trial.twin.faults.values[3:] = 0.06, -0.06
    rows = trial.run(4000)
    assert not rows["reseats"].any()
