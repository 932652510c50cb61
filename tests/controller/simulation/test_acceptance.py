"""What is accepted to start a rig with runs; what is refused says which field is to blame.

TENDRIL_LONG=1 tries 2000 actuators instead of some dozen.
"""

import os
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from pydantic import ValidationError

from controller.errors import ParameterError, sentence
from controller.schema.actuator import PRESETS, Actuator
from controller.schema.modes import Cause, Integrator, Mode
from controller.schema.parameters import ControllerParameters, RigParameters, SafetyLimits, Settings, TwinParameters
from controller.simulation.acceptance import require_built, require_running
from tests.controller.anything import actuators
from tests.controller.trial import Trial

pytestmark = pytest.mark.keyed()

LONG = os.environ.get("TENDRIL_LONG") == "1"
TOPPLED: dict[str, Any] = {
    "mass": 10.0,
    "length": 2.0,
    "table_rods": 2,
    "k": 1.6915004544539796,
    "b": 4.4887024552182355e-06,
    "alpha": 0.0,
    "rest_curvature": 50.0,
    "gravity": (9.81, 0.0),
    "chambers": ((0, 1), (1, 2)),
}
"""It has a rest in the observer's model, and none in the twin's."""
NAMES = [*Actuator.model_fields, "dt"]


def changed(**fields: Any) -> RigParameters:
    return RigParameters(actuator=Actuator.model_validate(PRESETS["P1"].model_dump() | fields))


def refusal(fields: dict[str, Any]) -> str:
    """Why no rig is started with an actuator of these fields, "" if one is."""
    try:
        require_running(RigParameters(actuator=Actuator.model_validate(fields)))
    except ValidationError as error:
        return sentence(error)
    except ParameterError as error:
        return str(error)
    return ""


ran: dict[str, int] = {}
"""How many were accepted, and refused for which field, of those that were tried last."""


@pytest.mark.timeout(7200 if LONG else 120)
@settings(
    max_examples=2000 if LONG else 60,
    deadline=None,
    derandomize=not LONG,
    suppress_health_check=list(HealthCheck),
)
@given(fields=actuators())
def check_any_actuator(fields: dict[str, Any]) -> None:
    if text := refusal(fields):
        named = [name for name in NAMES if re.search(rf"\b{name}\b", text)]
        assert named, text
        ran[named[0]] = ran.get(named[0], 0) + 1
        return
    ran["accepted"] = ran.get("accepted", 0) + 1
    trial = Trial(parameters=RigParameters(actuator=Actuator.model_validate(fields)))
    smap = trial.rig.control.smap
    far = smap.seed_tips[np.abs(smap.seeds).sum(axis=1).argmax()]
    rows = np.concatenate([trial.arm(), trial.run(900), trial.follow(*far, 1.0)])
    for name in ("u", "p_hat", "backbone", "twin_backbone", "pressure_cmd", "pressure_meas", "energy"):
        assert np.isfinite(rows[name]).all(), name
    assert not np.isin(rows["cause"], (Cause.NOT_FINITE, Cause.TOO_FAST)).any()
    assert rows["mode"][900] == Mode.HOLD


def test_any_actuator_that_is_accepted_runs_and_any_other_is_told_its_field() -> None:
    ran.clear()
    check_any_actuator()
    print(ran)
    assert ran.get("accepted", 0) > 5, ran
    assert len(ran) > 4, ran


def test_an_actuator_that_only_the_twin_cannot_be_built_with_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"gravity = \(.*no stable rest"):
        require_built(changed(**TOPPLED).model_copy(update={"twin": TwinParameters(rods=14)}))


@pytest.mark.parametrize(
    ("fields", "complaint"),
    [
        ({"k": 1e-300}, r"^k\.0 = 1e-300: .*0\.00001"),
        ({"mass": 1e-300}, r"^mass = 1e-300 kg is less than 0\.001 kg"),
        ({"k": (1e-4, 1000.0)}, r"^k goes from 0\.0001 to 1000: 10000 to 1 is the most"),
        ({"pressure_map": (1e-300, 1e-300)}, r"^pressure_map\.0 = 1e-300"),
        ({"pressure_max": 1e6, "u_max": 0.2}, r"^u_max = 0\.2 N m needs 804320 Pa: .* 340000 Pa"),
    ],
)
def test_a_refusal_names_field_value_and_bound(fields: dict[str, Any], complaint: str) -> None:
    assert re.search(complaint, refusal(PRESETS["P1"].model_dump() | fields))


def test_a_plant_that_rk4_cannot_compute_in_time_is_refused_with_the_step_that_can() -> None:
    quick = changed(k=1000.0, b=0.0, mass=0.001)
    require_built(quick)
    rk4 = quick.model_copy(update={"twin": quick.twin.model_copy(update={"integrator": Integrator.RK4})})
    with pytest.raises(ParameterError, match=r"^k, mass and length: .* and 100 in dt = 0\.001 s .*implicit"):
        require_built(rk4)


@pytest.mark.parametrize(
    "controller",
    [
        ControllerParameters(rods=2),
        ControllerParameters(rods=1000, integrator=Integrator.IMPLICIT),
        ControllerParameters(dt=5e-4),
    ],
)
def test_other_numbers_of_rods_integrators_and_periods_are_tried_too(controller: ControllerParameters) -> None:
    require_running(RigParameters(controller=controller))


def test_a_rig_that_swings_is_refused_unless_it_is_at_rest_with_the_gains_in_force() -> None:
    """Its limits let nothing swing at all; the feedback is what makes it."""
    nervous = RigParameters(limits=SafetyLimits(swing_max=1e-4, swing_ratio=0.0))
    with pytest.raises(ParameterError, match=r"does not stand still: REST \(OSCILLATION\)"):
        require_running(nervous)
    require_running(nervous, Settings(K_P=(0.0, 0.0), K_I=(0.0, 0.0), law=1))


def test_numbers_that_run_away_are_refused_by_a_watchdog_s_name() -> None:
    slow = RigParameters(limits=SafetyLimits(speed_max=1e-4))
    with pytest.raises(ParameterError, match=r"goes to E_STOP \(TOO_FAST\)"):
        require_running(slow)
