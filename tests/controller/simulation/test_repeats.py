"""A path that is learned by repeating it, on arms that the model is not."""

import math

import numpy as np
import pytest

from controller.assembly.controllers.registry import with_controller
from controller.errors import ParameterError
from controller.reference.library import reference
from controller.research.experiments.plant_scale import scaled
from controller.schema.actuator import PRESETS
from controller.schema.parameters import REPEATING, ControllerParameters, RigParameters, TwinParameters, usual_twin
from controller.simulation.metrics import Window, measure
from controller.simulation.repeats import asking, learn
from controller.simulation.run import for_reference, run

pytestmark = pytest.mark.keyed()

CONTROLLER = ControllerParameters()
PLANTS = {
    "twin": "",
    "k x 0.8": "k=0.8",
    "k x 1.2": "k=1.2",
    "weaker": "torque=0.8",
    "later": "delay=0.02",
    "less damped": "zeta=0.4",
}
BARS = {("circle_1hz", "P1", "twin"): 1.7, ("circle_2hz", "P3", "twin"): 2.0}
"""RMSE [mm] that the issue of this step asks for."""


def rig(actuator: str, plant: str, kind: str = "rod") -> RigParameters:
    body = PRESETS[actuator]
    twin = scaled(usual_twin(body, TwinParameters(plant=kind)), PLANTS[plant], body)
    return RigParameters(actuator=body, controller=CONTROLLER, twin=twin)


@pytest.mark.parametrize("plant", PLANTS)
@pytest.mark.parametrize(("name", "actuator"), [("circle_1hz", "P1"), ("circle_2hz", "P3"), ("digit_8", "P1")])
def test_eight_repeats_take_most_of_the_error_away(name: str, actuator: str, plant: str) -> None:
    path = reference(name, PRESETS[actuator], CONTROLLER)
    settings = for_reference(with_controller(REPEATING, "preview"), path)
    parameters = rig(actuator, plant)
    found = learn(parameters, path, settings, range(1, 9))
    assert all(map(math.isfinite, found.rmse)), "no repeat is broken off"
    after = measure(run(parameters, found.reference, settings, 0), path, Window.AFTER_APPROACH)["rmse"]
    least = 1e3 * min(found.rmse)
    assert after < 1.1 * least, "what is kept is the best one"
    assert after < (0.85 if name == "digit_8" else 0.5) * 1e3 * found.rmse[0]
    assert after < BARS.get((name, actuator, plant), math.inf)


def test_a_plant_of_another_kind_is_learned_too() -> None:
    path = reference("circle_1hz", PRESETS["P1"], CONTROLLER)
    settings = for_reference(with_controller(REPEATING, "preview"), path)
    found = learn(rig("P1", "twin", "cosserat"), path, settings, range(1, 9))
    assert min(found.rmse) < 0.25 * found.rmse[0]


def test_a_controller_without_a_plan_learns_nothing_and_says_so() -> None:
    path = reference("vu", PRESETS["P1"], CONTROLLER)
    with pytest.raises(ParameterError, match="'paper' follows no planned torques"):
        learn(rig("P1", "twin"), path, with_controller(REPEATING, "paper"), range(1))


def test_the_approach_is_planned_as_ever() -> None:
    path = reference("circle_1hz", PRESETS["P1"], CONTROLLER)
    c = np.full((len(path.p) - path.start, 2), 5e-3)
    asked = asking(path, c, CONTROLLER.dt).asked
    assert asked is not None
    assert np.array_equal(asked[: path.start - 200], path.p[: path.start - 200])
    assert asked[path.start :] == pytest.approx(path.p[path.start :] + 5e-3)
