"""How long a step may be, and which actuators are refused."""

import numpy as np
import pytest

import controller.assembly.stability
from controller.assembly.rig import build_rig
from controller.assembly.stability import largest_step
from controller.errors import ParameterError
from controller.schema.actuator import PRESETS
from controller.schema.modes import Integrator
from controller.schema.parameters import (
    OBSERVER_DAMPING_MAX,
    OBSERVER_GAIN_MAX,
    ControllerParameters,
    RigParameters,
)
from tests.controller.chains import preset

pytestmark = pytest.mark.keyed()


def rig_parameters(name: str, rods: int, integrator: Integrator, dt: float = 1e-3) -> RigParameters:
    controller = ControllerParameters(rods=rods, integrator=integrator, dt=dt)
    return RigParameters(actuator=PRESETS[name], controller=controller)


@pytest.mark.parametrize("name", PRESETS)
def test_rk4_at_1_ms_is_accepted_for_10_rods_and_refused_for_20(name: str) -> None:
    build_rig(rig_parameters(name, 10, Integrator.RK4), 1)
    with pytest.raises(ParameterError, match=r"^dt = 0\.001 s .* rods = 20: .* \S+ s; integrator = implicit"):
        build_rig(rig_parameters(name, 20, Integrator.RK4), 1)


def test_the_refusal_names_the_largest_stable_step() -> None:
    with pytest.raises(ParameterError) as refusal:
        build_rig(rig_parameters("P2", 10, Integrator.RK4, 1.2e-3), 1)
    named = float(str(refusal.value).split("dt is ")[1].split(" s")[0])
    assert 1.0e-3 < named < 1.2e-3
    build_rig(rig_parameters("P2", 10, Integrator.RK4, 0.99 * named), 1)


@pytest.mark.parametrize("name", PRESETS)
@pytest.mark.parametrize("rods", [40, 1000])
def test_the_implicit_step_is_accepted_for_any_number_of_rods(name: str, rods: int) -> None:
    rig = build_rig(rig_parameters(name, rods, Integrator.IMPLICIT), 1)
    assert rig.observer.gain_max.tolist() == [OBSERVER_GAIN_MAX, OBSERVER_DAMPING_MAX]


@pytest.mark.parametrize("name", PRESETS)
@pytest.mark.parametrize("softer", [1.0, 0.0])
def test_the_quick_bound_for_fine_rods_lies_just_below_the_exact_one(
    name: str, softer: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    plain = preset(name, 20, g=np.array([9.81, 1.0]))
    model = plain._replace(b=softer * plain.b, rest=np.linspace(0.0, 1.0, 20))
    exact = largest_step(model, 0.06, OBSERVER_GAIN_MAX)
    monkeypatch.setattr(controller.assembly.stability, "DENSE_MAX", 0)
    assert 0.9 * exact < largest_step(model, 0.06, OBSERVER_GAIN_MAX) < exact
