"""The observer with other gains: what the table says is what the runs say."""

import math

import pytest

from controller.research.experiments.observer_gains import TRIED, observer_gains, observer_jobs
from controller.research.experiments.reproduce import Reproduction, reproduce
from controller.research.experiments.results import Failure
from controller.simulation.case import Case, Setup
from controller.simulation.metrics import Window

pytestmark = pytest.mark.keyed()

CASES = (Case("circle_1hz"), Case("vu"), Case("circle_1hz", seed=1), Case("circle_1hz", "P2"))


def test_only_what_is_run_anyway_is_tried_and_when_quick_once() -> None:
    whole = observer_jobs(CASES, Setup(), quick=False)
    assert {job.case for job in whole} == {CASES[0]}
    assert [job.setup.gains.K_o[0] for job in whole] == [100.0, 200.0, 400.0, 100.0]
    [quick] = observer_jobs(CASES, Setup(), quick=True)
    assert (quick.case, quick.setup.controller.carry_on) == (CASES[0], False)
    assert observer_jobs(CASES[1:2], Setup(), quick=False) == ()


def test_a_carried_marker_and_a_stiffer_spring_bring_the_observer_nearer() -> None:
    told: list[Case] = []
    order = Reproduction(CASES[:1])
    found = reproduce(order, told.append)
    error = {(one.K_o, one.B_o, one.carry_on): one.observer_rmse["circle_1hz"] for one in found.observer}
    assert error[400.0, 0.0, True] < error[100.0, 0.0, True] < error[100.0, 0.0, False]
    assert error[100.0, 0.0, True] == found.outcomes[0].metrics[Window.WHOLE]["observer_rmse"]
    assert len(told) == found.runs == order.runs == 1 + len(TRIED)
    assert [one.case for one in found.outcomes] == [CASES[0]]


def test_a_run_that_was_broken_off_has_no_error() -> None:
    jobs = observer_jobs(CASES, Setup(), quick=True)
    broken = Failure(CASES[0], "FAULT")
    for one in observer_gains(jobs, [broken], Setup(), [broken]):
        assert math.isnan(one.observer_rmse["circle_1hz"])
