"""The paper's equations to the letter: what they change, and how they stand beside ours."""

import pytest

from controller.research.experiments.catalogue import LIVE_PATH, catalogue
from controller.research.experiments.letter import letter_jobs, letter_rows
from controller.research.experiments.results import Failure, Finished, trace
from controller.schema.modes import Integrator
from controller.schema.parameters import ControllerParameters
from controller.simulation.case import FITTED, Case, Setup, parameters_of, run_case, settings_of
from controller.simulation.metrics import Window

pytestmark = pytest.mark.keyed()


def finished(law: str) -> Finished:
    outcome = run_case(Case("circle_1hz", law=law), Setup())
    return Finished(outcome.case, outcome.reference, trace(outcome.rows, 1e-3), outcome.metrics)


def test_the_letter_has_no_fading_no_marker_carried_on_no_damping_of_ours_and_the_integrator_of_the_paper() -> None:
    setup = Setup()
    letter, ours = (parameters_of(Case("vu", law=law), setup).controller for law in ("paper", "ff+pi"))
    assert ours == setup.controller == FITTED
    changed = {name for name in ControllerParameters.model_fields if getattr(letter, name) != getattr(ours, name)}
    zero = {"weak_ratio", "weak_ratio_live", "feedback_lag", "full_gains_from", "observer_beta"}
    assert changed == zero | {"carry_on", "integrator"}
    assert letter.integrator is Integrator.RK4 and not letter.carry_on
    faster = Setup(controller=ControllerParameters(observer_kappa=40.0))
    assert parameters_of(Case("vu", law="paper"), faster).controller.observer_kappa == 1.0
    assert {getattr(letter, name) for name in zero} == {0.0}
    assert settings_of(Case("vu", law="paper"), setup.gains) == settings_of(Case("vu"), setup.gains)


def test_the_letter_is_run_once_for_every_case_under_ff_pi_but_the_live_path() -> None:
    cases = catalogue(seed=3)
    jobs = letter_jobs(cases, Setup())
    wanted = {(case.reference, case.actuator) for case in cases if case.law == "ff+pi"} - {(LIVE_PATH, "P1")}
    assert {(job.case.reference, job.case.actuator) for job in jobs} == wanted and len(jobs) == len(wanted)
    assert {(job.case.law, job.case.seed) for job in jobs} == {("paper", 3)}


def test_a_held_marker_lets_the_observer_lag_and_a_run_that_breaks_off_stands_with_its_sentence() -> None:
    ours, letter = finished("ff+pi"), finished("paper")
    assert letter.metrics[Window.WHOLE]["observer_rmse"] > ours.metrics[Window.WHOLE]["observer_rmse"]
    [row] = letter_rows([letter], [ours])
    assert (row.paper, row.ours) == (7.4, ours.metrics[Window.WHOLE]["rmse"]) and row.letter != row.ours
    [broken] = letter_rows([Failure(letter.case, "circle_1hz: HOLD")], [ours])
    assert (broken.letter, broken.failed) == (None, "circle_1hz: HOLD")
