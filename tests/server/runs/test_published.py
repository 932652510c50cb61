"""What is published is what runs: every reference of the library, as the server runs it on a fresh twin, beside the
figures of docs/control.md.
"""

import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from controller.assembly.controllers.registry import with_controller
from controller.reference import library
from controller.reference.reference import Reference
from controller.schema.actuator import PRESETS
from controller.schema.modes import Integrator, Mode, Request, RowKind
from controller.schema.parameters import ControllerParameters, RigParameters, Settings, usual_kappa
from controller.simulation.run import armed, plan, request
from server.drawing.references import listed
from server.operate.settings import FIRST
from server.runs.lap import velocity_gain
from server.runs.messages import Preview, PreviewBody
from server.runs.preview import predicted

pytestmark = pytest.mark.keyed("docs/reproduction.md", "docs/control.md")

DOCS = Path(__file__).parents[3] / "docs"
ROW = re.compile(r"^\| (\w[\w.]*), P1, ff\+pi \| rmse \| [\d.]+ \| ([\d.]+) \| [\d.]+ \|", re.MULTILINE)
REPRODUCED = {name: 1e-3 * float(ours) for name, ours in ROW.findall((DOCS / "reproduction.md").read_text())}
"""RMSE [m] by the names of the reproduction's table, on P1 with the paper's law and gains that were fitted to it."""
RUNS = re.compile(r"^\| ([\w.]+) \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \|$", re.MULTILINE)
CONTROLLERS = ("paper", "letter", "preview", "adaptive")
PUBLISHED = {
    (name, controller): 1e-3 * float(error)
    for name, *errors in RUNS.findall((DOCS / "control.md").read_text())
    for controller, error in zip(CONTROLLERS, errors, strict=True)
}
"""RMSE [m] of each reference of the library on a fresh twin."""
NEAR_SHARE = 0.05
"""By so much may a run differ from what is published, as a share of it."""
BODY = PRESETS["P1"]
KAPPA = usual_kappa(BODY, Integrator.IMPLICIT)
RIG = RigParameters(actuator=BODY, controller=ControllerParameters(observer_kappa=KAPPA))
HAND, REST = Settings(), np.zeros(2)
"""As `tendril up` begins but for its controller, `preview`: here it is `paper`, which has K_FF."""


@cache
def run(name: str, controller: str = "paper") -> Preview:
    """The whole run of a reference, from rest, with the settings that a server begins with but for the controller."""
    return predicted(PreviewBody(reference=name), RIG, with_controller(HAND, controller), REST)


def rmse(name: str, controller: str) -> float:
    """Of a run to its end [m]."""
    found = run(name, controller)
    assert found.broken_off == "" and found.rmse is not None, found.broken_off
    return found.rmse


def test_the_tables_are_found() -> None:
    assert {"step", "vu", "circle_1hz", "vertical_1hz", "horizontal_1hz", "digits"} <= REPRODUCED.keys()
    assert PUBLISHED.keys() == {(info.name, controller) for info in listed(RIG) for controller in CONTROLLERS}
    assert HAND == with_controller(HAND, "paper")


def test_a_server_begins_with_preview_as_usual() -> None:
    assert HAND.model_copy(update=FIRST) == with_controller(HAND, "preview")


@pytest.mark.parametrize(("name", "controller"), PUBLISHED)
def test_a_run_gives_what_is_published(name: str, controller: str) -> None:
    assert rmse(name, controller) == pytest.approx(PUBLISHED[name, controller], rel=NEAR_SHARE)


@pytest.mark.parametrize("name", REPRODUCED)
def test_preview_is_ahead_of_the_reproduced_paper(name: str) -> None:
    names = [f"digit_{value}" for value in range(10)] if name == "digits" else [name]
    assert np.mean([rmse(one, "preview") for one in names]) < REPRODUCED[name]


@pytest.mark.parametrize("info", listed(RIG), ids=lambda info: info.name)
def test_each_reference_says_the_velocity_feedforward_that_it_runs_with(info) -> None:  # type: ignore[no-untyped-def]
    wanted = library.PLANS[info.name].velocity_feedforward if info.name in library.PLANS else False
    assert info.K_FF == (RIG.controller.reference_K_FF if wanted else 0.0)
    assert run(info.name).K_FF == (info.K_FF, info.K_FF)
    if wanted and info.frequency < 1.5:  # P1 follows nothing faster, with it or without
        plain = predicted(PreviewBody(reference=info.name, K_FF="settings"), RIG, HAND, REST)
        assert plain.K_FF == (0.0, 0.0) and plain.rmse is not None
        assert rmse(info.name, "paper") < max(plain.rmse, 1e-3)


def test_an_operators_own_velocity_feedforward_is_the_one_in_force() -> None:
    chosen = HAND.model_copy(update={"K_FF": (0.05, 0.0)})
    assert predicted(PreviewBody(reference="circle_1hz"), RIG, chosen, REST).K_FF == (0.05, 0.0)


@pytest.mark.parametrize("K_FF", [(0.0, 0.0), (0.05, 0.0)])
@pytest.mark.parametrize("fed", [True, False])
def test_what_is_said_is_what_the_loop_uses(fed: bool, K_FF: tuple[float, float]) -> None:
    settings = HAND.model_copy(update={"K_FF": K_FF})
    simulation = armed(RIG, settings, seed=1)
    reference = library.reference("circle_1hz", RIG.actuator, RIG.controller)
    kind = RowKind.FED if fed else RowKind.KNOWN
    plan(simulation.rig.control, Reference("fed", reference.p, reference.start, known=True, velocity_feedforward=fed))
    request(simulation, Request.TRACK)
    rows = simulation.run(reference.start + 100)
    assert rows["mode"][-1] == Mode.TRACK
    assert tuple(simulation.rig.control.state[0]["K_FF"]) == velocity_gain(kind, RIG, settings, own_gains=False)
