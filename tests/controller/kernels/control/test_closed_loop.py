"""`tendril stability`: what it says of observer and loop is what the tick does, and how runs on the twin come out."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.main import get_command
from typer.testing import CliRunner

from controller.assembly.rig import build_rig
from controller.errors import TendrilError
from controller.research.stability import closed_loop
from controller.research.stability.closed_loop import Growth
from controller.research.stability.stability import Question, every_loop, grid, growth_at
from controller.schema.actuator import PRESETS
from controller.schema.layout import to_record
from controller.schema.parameters import ControllerParameters, RigParameters, Settings, TwinParameters
from controller.simulation.case import Case, Setup, run_case
from controller.simulation.metrics import Window
from server.cli.main import app
from server.cli.research.stability import Wanted, plant_of
from tests.controller.kernels.observer.test_observer import growth

pytestmark = pytest.mark.keyed("server/cli/research/commands.py")

TIP, ROD_6 = (9,), (5,)
UNDAMPED = ControllerParameters(observer_beta=0.0)


def question(actuator: str, sensed: tuple[int, ...], controller: ControllerParameters | None = None) -> Question:
    parameters = RigParameters(actuator=PRESETS[actuator], controller=controller or ControllerParameters())
    return Question(parameters, sensed, 100.0, 0.0)


def stable(asked: Question) -> bool:
    return all(loop.growth().stable for loop in every_loop(asked))


@pytest.mark.parametrize("sensed", [TIP, ROD_6])
def test_the_growth_of_the_observer_is_that_of_its_tick(sensed: tuple[int, ...]) -> None:
    asked = question("P3", sensed)
    rig, used = build_rig(asked.parameters, 1), sum(1 << sensor for sensor in sensed)
    gains = to_record(Settings(K_o=(100.0, 100.0), B_o=(0.0, 0.0)))[0]
    for u in grid(asked.parameters, rig)[::5]:
        of_the_tick = growth(rig.observer, rig.sensing, gains, used, (float(u[0]), float(u[1])))
        assert growth_at(asked, rig, u) == pytest.approx(of_the_tick, abs=1e-6)


@pytest.mark.parametrize("actuator", PRESETS)
def test_the_loop_is_stable_with_the_tip_and_with_rod_6_alone(actuator: str) -> None:
    for sensed in (TIP, ROD_6, ROD_6 + TIP):
        assert stable(question(actuator, sensed))


@pytest.mark.parametrize(("actuator", "path"), [("P1", "horizontal_1hz"), ("P3", "circle_1hz")])
def test_a_run_swings_up_where_the_loop_does_and_not_where_it_is_stable(actuator: str, path: str) -> None:
    """Rod 6 alone at 1 Hz: what lies beyond it must be damped."""
    case, undamped = Case(path, actuator, "rod6"), replace(question(actuator, ROD_6, UNDAMPED), library=True)
    assert not stable(undamped)
    with pytest.raises(TendrilError, match="OSCILLATION"):
        run_case(case, Setup(controller=UNDAMPED))
    assert stable(replace(question(actuator, ROD_6), library=True))
    assert run_case(case, Setup()).metrics[Window.WHOLE]["rmse"] < 15.0


def test_a_plant_with_little_damping_and_more_delay_has_less_margin() -> None:
    usual = replace(question("P1", ROD_6), library=True)
    worse = usual.parameters.model_copy(update={"twin": TwinParameters(zeta=0.15, dead_time=0.07)})
    most = [max(loop.growth().swings for loop in every_loop(one)) for one in (usual, replace(usual, parameters=worse))]
    assert most[0] < 1.0 < most[1]


FAMILY = [(zeta, delay) for zeta in (0.1, 0.5) for delay in (0.04, 0.07)]


@pytest.mark.parametrize("sensed", [TIP, ROD_6, ROD_6 + TIP])
@pytest.mark.parametrize("actuator", PRESETS)
def test_where_the_tip_is_led_by_hand_the_loop_is_stable_whatever_the_arm_s_damping(
    actuator: str, sensed: tuple[int, ...]
) -> None:
    """No damping that no one measured, nor a longer air line: the feedback rolls off below the first mode."""
    asked = question(actuator, sensed)
    for zeta, delay in FAMILY:
        plant = asked.parameters.model_copy(update={"twin": TwinParameters(zeta=zeta, dead_time=delay)})
        assert stable(replace(asked, parameters=plant)), f"zeta {zeta}, dead time {delay} s"


@pytest.mark.parametrize("change", [{"factor": 20.0}, {"factor": 0.6 - 0.8j}, {"more_delay": 150}], ids=str)
def test_the_largest_eigenvalues_are_those_of_all(change: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    loops = [*every_loop(question("P2", ROD_6 + TIP)), *every_loop(replace(question("P1", ROD_6), library=True))][::5]
    found = [loop.growth(**change) for loop in loops]
    monkeypatch.setattr(closed_loop, "LARGE", 10**9)
    for loop, one in zip(loops, found, strict=True):
        assert one == pytest.approx(loop.growth(**change), abs=1e-11)


def test_a_swing_that_grows_or_a_quick_drift_is_no_stability() -> None:
    assert Growth(1.00001, 0.999).stable
    assert not Growth(1.001, 0.999).stable and not Growth(1.00001, 1.00001).stable


def figures(folder: Path, *words: str) -> dict[str, object]:
    file = folder / "stability.json"
    answer = CliRunner().invoke(app, ["stability", *words, "--json", str(file)])
    assert answer.exit_code == 0, answer.output
    return json.loads(file.read_text())  # type: ignore[no-any-return]


def test_the_command_takes_the_gains_that_a_rig_begins_with() -> None:
    options = {one.name: one.default for one in get_command(app).commands["stability"].params}  # type: ignore[attr-defined]
    assert (options["k_o"], options["b_o"]) == (Settings().K_o[0], Settings().B_o[0])


def test_the_command_gives_growths_bounds_and_margins(tmp_path: Path) -> None:
    found = figures(tmp_path, "--actuator", "P2", "--rods", "5", "--sense", "6,10", "--k-o", "500", "--b-o", "5")
    assert found["accepted"] and (found["largest_k_o"], found["largest_b_o"]) == (500.0, 5.0)
    assert 0.9 < found["growth"] < 1.0 and found["sense"] == [6, 10]  # type: ignore[operator]
    assert found["closed_loop_stable"] and found["closed_loop_growth"] < 1.0001  # type: ignore[operator]
    margins = found["margins"]
    assert isinstance(margins, dict) and set(margins) == {"gain", "phase_deg", "delay_ms"}
    plant = found["plant"]
    assert isinstance(plant, dict) and plant["zeta"]["value"] == TwinParameters().zeta
    assert [(plant[name]["source"], plant[name]["note"]) for name in ("zeta", "kappa")] == [
        ("assumed", "fit to the paper")
    ] * 2
    assert (
        1.2 < margins["gain"] < 1000.0 and 20.0 < margins["phase_deg"] <= 180.0 and 5.0 < margins["delay_ms"] <= 200.0
    )


def test_the_plant_s_numbers_are_those_that_are_given_and_the_twin_s_else() -> None:
    plant = plant_of(RigParameters(), Wanted("10", 100.0, 0.0, zeta=0.1))
    assert [(number.value, number.source) for number in plant.values()] == [
        (0.1, "given"),
        (TwinParameters().kappa, "assumed"),
    ]


def test_the_command_says_what_rk4_does_not_take(tmp_path: Path) -> None:
    found = figures(tmp_path, "--actuator", "P2", "--integrator", "rk4", "--b-o", "5", "--rods", "10")
    assert not found["accepted"] and 0.5 < found["largest_b_o"] < 5.0  # type: ignore[operator]


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--sense", "11"], "sense = 11 is outside [1, 10]"),
        (["--sense", "tip"], "sense = 'tip' is not a list of sensors"),
        (["--k-o", "-1"], "k-o = -1 is outside [0, 1e+06]"),
        (["--b-o", "nan"], "b-o = nan is outside"),
        (["--integrator", "rk4", "--rods", "40"], "too long for RK4"),
        (["--zeta", "2.5"], "zeta = 2.5 is outside [0, 2]"),
        (["--kappa", "nan"], "kappa = nan is outside [0.1, 500]"),
        (["--rig", "nowhere"], "rig = nowhere: no first mode of actuator P1 is kept in"),
    ],
)
def test_wrong_words_are_named_with_their_bounds(words: list[str], complaint: str) -> None:
    answer = CliRunner().invoke(app, ["stability", *words])
    assert answer.exit_code != 0 and complaint in str(answer.exception or "") + answer.output


def test_more_rods_are_looked_at_with_few_poses() -> None:
    many = question("P1", TIP, ControllerParameters(rods=300))
    rig = build_rig(many.parameters, 1)
    found = [growth_at(many, rig, u) for u in grid(many.parameters, rig)[:2]]
    assert np.all(np.array(found) < 1.0)
