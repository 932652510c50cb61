"""The slot: what is in it, how it is chosen, and what a controller can not do."""

import importlib
import math

import numpy as np
import pytest

from controller.arrays import Array, Record
from controller.assembly.controllers import slot
from controller.assembly.controllers.definition import Controller
from controller.assembly.controllers.registry import OURS, controllers, index_of, with_controller
from controller.errors import ParameterError
from controller.kernels.compiled import kernel
from controller.realtime.followable import mistuned
from controller.reference.library import reference
from controller.reference.reference import Reference
from controller.schema.actuator import PRESETS
from controller.schema.modes import Cause, Mode, Request
from controller.schema.parameters import REPEATING, ControllerParameters, RigParameters, Settings, TwinParameters
from controller.simulation.metrics import Window, measure
from controller.simulation.run import attempt, plan
from tests.controller.trial import Trial, true_tip, twin_with
from tests.keyed import ROOT

pytestmark = pytest.mark.keyed("docs/examples/own_controller.py")

PAPER, LETTER, PREVIEW = (index_of(name) for name in ("paper", "letter", "preview"))
PLANTS: dict[str, TwinParameters] = {
    "softer": TwinParameters(stiffness_scale=0.8),
    "stiffer": TwinParameters(stiffness_scale=1.2),
    "later": TwinParameters(dead_time=0.07),
    "less damped": TwinParameters(zeta=0.1),
    "a Cosserat rod": TwinParameters(plant="cosserat"),
}


def followed(name: str, controller: str, twin: TwinParameters, actuator: str = "P1") -> float:
    """RMSE after the approach [mm]; inf for a run that the rig broke off."""
    parameters = RigParameters(actuator=PRESETS[actuator], twin=twin)
    path = reference(name, parameters.actuator, parameters.controller)
    rows = attempt(parameters, path, with_controller(REPEATING, controller), 0)
    return measure(rows, path, Window.AFTER_APPROACH)["rmse"] if (rows["mode"] == Mode.TRACK).all() else math.inf


@pytest.mark.parametrize("plant", PLANTS)
@pytest.mark.parametrize("name", ["circle_1hz", "vu", "digit_8", "step"])
def test_neither_paper_nor_preview_is_stopped_on_an_arm_that_is_another_one(name: str, plant: str) -> None:
    errors = {controller: followed(name, controller, PLANTS[plant]) for controller in ("paper", "preview")}
    assert max(errors.values()) < 25.0
    assert errors["preview"] < 1.25 * errors["paper"]


def test_to_the_letter_a_softer_arm_is_stopped() -> None:
    """What the kept torque is for."""
    assert followed("circle_1hz", "letter", PLANTS["softer"]) == math.inf


@pytest.mark.parametrize(
    ("name", "actuator", "ratio", "most"),
    [
        ("circle_1hz", "P1", 0.4, 3.7),
        ("vu", "P1", 0.6, 1.2),
        ("digit_8", "P1", 0.6, 1.5),
        ("circle_2hz", "P3", 0.3, 4.0),
    ],
)
def test_on_the_nominal_arm_preview_is_a_fraction_of_the_paper(
    name: str, actuator: str, ratio: float, most: float
) -> None:
    ours = followed(name, "preview", TwinParameters(), actuator)
    assert ours < most and ours < ratio * followed(name, "paper", TwinParameters(), actuator)


@pytest.mark.parametrize("back", [PAPER, LETTER])
def test_a_controller_changes_in_hold_without_a_bump_and_not_on_the_way(back: int) -> None:
    trial = Trial(parameters=twin_with(stiffness_scale=0.8))
    trial.arm()
    trial.follow(0.10, 0.14, 3.0)
    chosen = with_controller(trial.settings, "preview")
    trial.switch(controller=chosen.controller, tuning=chosen.tuning)
    assert (trial.run(200)["controller"] == PAPER).all(), "the tip is on its way"
    rows = [trial.ask(Request.HOLD, ticks=300)]
    assert (rows[0]["controller"][1:] == PREVIEW).all()
    trial.switch(controller=back)
    rows.append(trial.run(300))
    assert rows[1]["controller"][-1] == back
    assert np.abs(np.diff(np.concatenate(rows)["u"], axis=0)).max() < 0.2e-3


def test_what_holds_the_arm_is_not_foreseen_to_move_it_again() -> None:
    trial = Trial(parameters=twin_with(stiffness_scale=0.8))
    trial.arm()
    trial.follow(0.10, 0.14, 3.0)
    before = true_tip(trial.ask(Request.HOLD, ticks=4000))[-1]
    chosen = with_controller(trial.settings, "preview")
    trial.switch(controller=chosen.controller, tuning=chosen.tuning)
    assert np.linalg.norm(true_tip(trial.run(1500)) - before, axis=1).max() < 0.5e-3


def test_what_is_tuned_is_named_with_its_bound() -> None:
    settings = with_controller(Settings(), "preview", {"K_P": 0.5})
    assert (settings.controller, settings.tuning[:3]) == (PREVIEW, (0.5, 4.0, 0.1))
    for name, tuning, complaint in [
        ("mpc", {}, "controller = 'mpc' is not one of paper, letter, preview, adaptive"),
        ("preview", {"K_D": 1.0}, "K_D: controller preview is not one of K_P, K_I, lag"),
        ("paper", {"K_P": 1.0}, "K_P: controller paper is not tuned by any"),
        ("preview", {"K_P": 9.0}, "controller preview: K_P = 9"),
    ]:
        with pytest.raises(ParameterError, match=complaint):
            with_controller(Settings(), name, tuning)


def test_the_rig_itself_refuses_what_no_controller_of_it_takes() -> None:
    infos = tuple(one.info() for one in controllers())
    settings = with_controller(Settings(), "preview")
    assert mistuned(settings, infos) == mistuned(Settings(), infos) == ""
    assert mistuned(settings.model_copy(update={"controller": 9}), infos) == "refused: controller = 9 is outside [0, 3]"
    wrong = settings.model_copy(update={"tuning": (0.3, 40.0, *settings.tuning[2:])})
    assert mistuned(wrong, infos) == "refused: preview: K_I = 40 is outside [0, 20] 1/s"


@kernel
def shows_all(now: Record, reference: Array, tuning: Array, memory: Array, out_wanted: Record) -> None:
    """Counts its ticks, and shows what it was told. Not in the paper: a test's."""
    memory[0] += 1.0
    signals = out_wanted.signals
    signals[0], signals[1], signals[2], signals[3] = memory[0], now.row, now.left, now.live
    if 0 <= now.row < now.rows:
        signals[4], signals[5] = reference[now.row, 0], now.p_ref[0]


@kernel
def no_number(now: Record, reference: Array, tuning: Array, memory: Array, out_wanted: Record) -> None:
    """Has a mistake. Not in the paper: a test's."""
    out_wanted.u_fb[0] = math.nan


@kernel
def pushes(now: Record, reference: Array, tuning: Array, memory: Array, out_wanted: Record) -> None:
    """Asks for more than there is. Not in the paper: a test's."""
    out_wanted.u_ff[0] = 1.0


def example(monkeypatch: pytest.MonkeyPatch) -> Controller:
    """That of the documents, as an installed package would offer it."""
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "examples"))
    return importlib.import_module("own_controller").INTEGRAL  # type: ignore[no-any-return]


def test_the_example_of_the_documents_brings_the_tip_to_where_it_is_wanted(monkeypatch: pytest.MonkeyPatch) -> None:
    own = example(monkeypatch)
    trial = with_controllers(monkeypatch, own)
    trial.switch(tuning=tuple(own.usual.tolist()))
    trial.arm()
    rows = trial.follow(0.10, 0.14, 8.0)
    assert np.linalg.norm(rows["error"][-1000:].mean(axis=0)) < 1e-3
    assert rows["signals"][-1, :2] == pytest.approx(rows["u_fb"][-1], abs=1e-6)
    assert [(one.name, one.usual, one.low, one.high, one.unit) for one in own.info().tuning] == [
        ("K_I", 1.5, 0.0, 10.0, "1/s")
    ]


def with_controllers(monkeypatch: pytest.MonkeyPatch, own: Controller) -> Trial:
    """A trial with a controller of somebody else."""
    monkeypatch.setattr(slot, "controllers", lambda: (*OURS, own))
    monkeypatch.setattr(slot, "_COMPILED", {})
    return Trial(controller=len(OURS))


def with_law(monkeypatch: pytest.MonkeyPatch, law: object) -> Trial:
    """The same, by its kernel."""
    return with_controllers(monkeypatch, Controller("own", "Somebody's", law, "nowhere"))  # type: ignore[arg-type]


def test_somebody_s_own_controller_is_shown_where_the_reference_is_and_remembers(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    trial = with_law(monkeypatch, shows_all)
    trial.arm()
    trial.follow(0.10, 0.14, 2.0)
    trial.ask(Request.HOLD, ticks=10)
    here = trial.rig.control.state[0]["p_ref"].copy()
    p = here + np.linspace(0.0, 0.01, 200)[:, None] * [0.0, 1.0]
    plan(trial.rig.control, Reference("up", p, 0))
    rows = trial.ask(Request.TRACK, ticks=150)
    signals = rows["signals"]
    assert np.array_equal(signals[:, 1], np.arange(150)) and np.array_equal(signals[:, 2], 199 - np.arange(150))
    assert signals[:, 4] == pytest.approx(p[:150, 0]) and signals[:, 5] == pytest.approx(p[:150, 0], abs=1e-5)
    assert np.array_equal(np.diff(signals[:, 0]), np.ones(149)) and (signals[:, 3] == 1).all()


def test_a_controller_that_says_no_number_is_an_e_stop(monkeypatch: pytest.MonkeyPatch) -> None:
    trial = with_law(monkeypatch, no_number)
    trial.run(50)
    rows = trial.ask(Request.ARM, ticks=20)
    assert (rows["mode"][-1], rows["cause"][-1]) == (Mode.E_STOP, Cause.NOT_FINITE)
    assert np.isfinite(rows["u"]).all() and not rows["u"][-1].any()


def test_a_controller_that_asks_for_more_than_there_is_gets_what_is_admissible(monkeypatch: pytest.MonkeyPatch) -> None:
    trial = with_law(monkeypatch, pushes)
    trial.arm()
    rows = trial.run(200)
    polygon = trial.rig.control.smap.polygon
    assert rows["saturated"].any()
    assert ((rows["u"] @ polygon.normals.T) <= polygon.bounds * (1 + 1e-9)).all()
    slew = ControllerParameters().torque_slew_max * 1e-3
    assert np.abs(np.diff(rows["u"], axis=0)).max() <= slew + 1e-12
