"""Rows from runs that were not run: what is averaged over what, and what a failure leaves."""

import json
from collections.abc import Iterable

import numpy as np
import pytest

from controller.reference.library import PLANS
from controller.reference.reference import Reference
from controller.research.experiments.catalogue import CASES, catalogue
from controller.research.experiments.fitted_intervals import with_intervals
from controller.research.experiments.frequency_sweep import frequency_sweep
from controller.research.experiments.paper_rows import DIGITS, EXPERIMENTS, PAPER_ROWS, paper_row
from controller.research.experiments.result_rows import ALWAYS, result_rows
from controller.research.experiments.results import Failure, Finished, ResultRow, Results, Trace
from controller.research.report.result_json import result_json, row_json
from controller.schema.parameters import TwinParameters
from controller.simulation.case import Case, Setup
from controller.simulation.metrics import Window

pytestmark = pytest.mark.keyed()

WHOLE, AFTER = Window.WHOLE, Window.AFTER_APPROACH
CONTRACT = ("experiment", "actuator", "law", "metric", "unit", "paper", "paper_low", "paper_high", "ours", "ours_std")
NO_TRACE = Trace(*([np.empty(0)] * 8), *([np.empty(0, np.float32)] * 2))


def finished(case: Case, whole: float = 2.0, after: float = 1.0) -> Finished:
    """A run whose metrics, all that such a run has, are `whole` or `after`."""
    plan = PLANS.get(case.reference)
    names = [*ALWAYS]
    if plan is not None and plan.steps:
        names += ["sse", "step_spread"]
    if plan is not None and plan.frequency is not None:
        names += ["lag_deg_x", "lag_deg_y"]
    metrics = {WHOLE: dict.fromkeys(names, whole), AFTER: dict.fromkeys(names, after)}
    return Finished(case, Reference(case.reference, np.zeros((1, 2)), 0), NO_TRACE, metrics)


def made(outcomes: Iterable[Finished], failures: Iterable[Failure] = ()) -> dict[tuple[str, str, str, str], ResultRow]:
    outcomes, failures = tuple(outcomes), tuple(failures)
    rows = result_rows(outcomes, failures, frequency_sweep(outcomes, failures))
    assert len({row.about.key for row in rows}) == len(rows)
    return {row.about.key: row for row in rows}


def test_every_case_is_in_the_catalogue_once_when_quick_and_task_4_five_times_otherwise() -> None:
    assert catalogue(7, quick=True) == tuple(Case(one.reference, one.actuator, one.law, 7) for one in CASES)
    whole = catalogue(7)
    assert len(set(whole)) == len(whole)
    assert [one.seed for one in whole if (one.reference, one.law) == ("sensing_sweep", "rod6")] == [7, 8, 9, 10, 11]
    assert [one.seed for one in whole if (one.reference, one.actuator) == ("vu", "P2")] == [7, 8, 9]


def test_every_experiment_and_every_number_of_the_paper_gets_a_row() -> None:
    rows = made(finished(case) for case in catalogue(quick=True))
    assert {key[0] for key in rows} == set(EXPERIMENTS)
    assert {paper.key for paper in PAPER_ROWS} <= rows.keys()
    assert ("vu", "P1", "ff+pi", "sse") not in rows and ("vu", "P1", "ff+pi", "lag_deg_x") not in rows


def test_ours_is_the_mean_over_seeds_in_the_papers_window_with_the_other_one_beside() -> None:
    rows = made(finished(Case("vu", seed=seed), whole=9.0 + seed, after=2.0 + seed) for seed in (0, 1, 2))
    row = rows["vu", "P1", "ff+pi", "rmse"]
    assert (row.window, row.ours, row.ours_std, row.ours_other_window, row.seeds) == (AFTER, 3.0, 1.0, 10.0, 3)
    assert row.ratio == pytest.approx(3.0 / 1.9)
    circle = made([finished(Case("circle_1hz"))])["circle_1hz", "P1", "ff+pi", "rmse"]
    assert (circle.window, circle.ours, circle.ours_std) == (WHOLE, 2.0, None)


def test_digits_are_averaged_over_the_ten_of_each_seed_before_the_seeds() -> None:
    runs = [
        finished(Case(digit, seed=seed), after=value + 10.0 * seed)
        for value, digit in enumerate(DIGITS)
        for seed in (0, 1)
    ]
    row = made(runs)["digits", "P1", "ff+pi", "rmse"]
    assert (row.ours, row.seeds) == (9.5, 2)
    assert row.ours_std == pytest.approx(10.0 / 2.0**0.5)


def test_a_reduction_is_of_each_seed_against_ff_and_missing_where_either_failed() -> None:
    key = "sensing_circle", "P1", "rod6", "reduction"
    ff = [finished(Case("sensing_circle", law="ff", seed=seed), whole=10.0) for seed in (0, 1)]
    rod6 = [finished(Case("sensing_circle", law="rod6", seed=seed), whole=4.0 + 2.0 * seed) for seed in (0, 1)]
    row = made([*ff, *rod6])[key]
    assert (row.ours, row.seeds, row.about.paper) == (pytest.approx(50.0), 2, 74.0)
    failures = {law: Failure(Case("sensing_circle", law=law, seed=1), f"{law}: FAULT") for law in ("ff", "rod6")}
    for law, others in (("ff", [*ff[:1], *rod6]), ("rod6", [*ff, *rod6[:1]])):
        row = made(others, [failures[law]])[key]
        assert row.ours is None and f"{law}: FAULT" in row.failed


def test_one_broken_off_run_leaves_no_number_and_says_why() -> None:
    runs = [finished(Case("circle_2hz", "P3", seed=seed)) for seed in (0, 1)]
    rows = made(runs, [Failure(Case("circle_2hz", "P3", seed=2), "circle_2hz: FAULT")])
    row = rows["circle_2hz", "P3", "ff+pi", "lag_deg_x"]
    assert (row.ours, row.ours_std, row.ratio) == (None, None, None)
    assert row.failed == "1 of 3 runs: circle_2hz: FAULT"
    assert ("circle_2hz", "P3", "ff+pi", "rmse") in rows


def test_a_digit_that_fails_fails_the_mean() -> None:
    runs = [finished(Case(digit)) for digit in DIGITS[:-1]]
    row = made(runs, [Failure(Case(DIGITS[-1]), "digit_9: FAULT")])["digits", "P1", "ff+pi", "rmse"]
    assert (row.ours, row.failed) == (None, "digit_9: FAULT")


def test_the_frequency_sweep_is_one_row_with_its_curve() -> None:
    shares = {"frequency_sweep_0.1hz": 0.1, "frequency_sweep_1hz": 0.2}
    runs = [finished(Case(name), after=share) for name, share in shares.items()]
    failure = Failure(Case("frequency_sweep_2hz"), "frequency_sweep_2hz: FAULT")
    rows = made(runs, [failure])
    row = rows["frequency_sweep", "P1", "ff+pi", "feedback_share"]
    assert (row.ours, row.failed, row.about.paper) == (None, failure.sentence, None)
    assert [point["share"] for point in row.extra["curve"]] == [0.1, 0.2, None]
    ended = made([*runs, finished(Case("frequency_sweep_2hz"), after=0.3)])
    assert ended["frequency_sweep", "P1", "ff+pi", "feedback_share"].ours == 0.3
    alone = frequency_sweep(runs, [failure], [finished(Case("frequency_sweep_1hz"), after=0.15)])
    assert [point.share_pi for point in alone] == [None, 0.15, None]
    assert row.extra["paper_curve"] == [{"frequency": 0.1, "share": 0.12}, {"frequency": 2.0, "share": 0.32}]


def test_the_json_has_the_keys_that_were_agreed_and_no_nan() -> None:
    outcomes = (finished(Case("vu"), after=float("nan")),)
    failures = (Failure(Case("frequency_sweep_2hz"), "FAULT"),)
    sweep = frequency_sweep(outcomes, failures)
    rows = result_rows(outcomes, failures, sweep)
    results = Results(outcomes, failures, rows, (), sweep, (), (), 1.5, Setup(), (0,), 2, True, 2)
    found = json.loads(json.dumps(result_json(results), allow_nan=False))
    assert set(CONTRACT) | {"role"} <= set(found["rows"][0])
    assert (found["seconds"], found["rows"][0]["ours"]) == (1.5, None)
    assert found["twin"] == json.loads(Setup().twin.model_dump_json())
    assert found["failures"] == [
        {"reference": "frequency_sweep_2hz", "actuator": "P1", "law": "ff+pi", "seed": 0, "failed": "FAULT"}
    ]


def test_a_row_has_the_interval_of_the_fit_only_under_that_fit() -> None:
    fit = {"twin": {"kappa": Setup().twin.kappa}, "gains": {}, "spread": [{**KEYS, "low": 5.0, "high": 7.0}]}
    row = ResultRow(paper_row("circle_1hz", "P1", "ff+pi", "rmse"), 6.0, None, Window.WHOLE, None, 1)
    [found] = with_intervals([row], Setup(), fit)
    assert (found.interval, found.inside) == ((5.0, 7.0), False)  # the paper has 7.4
    assert {name: row_json(found)[name] for name in ("interval", "inside")} == {"interval": [5.0, 7.0], "inside": False}
    older = {**fit, "twin": {**fit["twin"], "cosserat": {"stiffening": 0.3}}}  # a field was added since
    assert with_intervals([row], Setup(), older)[0].interval == (5.0, 7.0)
    [other] = with_intervals([row], Setup(twin=TwinParameters(kappa=7.0)), fit)
    [foreign] = with_intervals([row], Setup(twin=TwinParameters(plant="cosserat")), fit)
    assert other.interval is foreign.interval is None and "interval" not in row_json(other)


KEYS = {"experiment": "circle_1hz", "actuator": "P1", "law": "ff+pi", "metric": "rmse"}
