"""Task 4's summary of runs whose errors are known."""

import math

import numpy as np
import pytest
from scipy.stats import t

from controller.reference.reference import Reference
from controller.research.experiments.results import Failure, Finished, Trace
from controller.research.experiments.sensing_summary import CLEARLY, EQUAL, in_order, sensing_summary, summarised, welch
from controller.simulation.case import Case
from controller.simulation.metrics import Window

pytestmark = pytest.mark.keyed()

NO_TRACE = Trace(*([np.empty(0)] * 8), *([np.empty(0, np.float32)] * 2))
REFERENCE = Reference("sensing_circle", np.zeros((1, 2)), 0)
PAPER_LIKE = {"ff": (20.0, 22.0), "rod6": (15.0, 15.0), "rod10": (9.0, 10.8), "rod6+10": (9.0, 10.0)}


def test_errors_are_normalised_by_the_largest_of_all_runs_and_reduced_against_ff() -> None:
    found = summarised("sensing_sweep", PAPER_LIKE)
    by_law = {law.law: law for law in found.laws}
    assert by_law["ff"].normalised == pytest.approx((20.0 / 22.0, 1.0))
    assert by_law["rod6"].reduction == pytest.approx(1.0 - 15.0 / 21.0)
    assert (by_law["ff"].reduction, found.paper_reduction, found.ordered) == (0.0, 0.27, True)


def test_a_law_that_failed_is_left_out_and_the_order_is_not_the_papers() -> None:
    found = summarised("sensing_circle", {law: PAPER_LIKE[law] for law in ("rod6", "rod10")})
    assert [law.law for law in found.laws] == ["rod6", "rod10"]
    assert math.isnan(found.laws[0].reduction)
    assert not found.ordered and found.p_value is None


def finished(case: Case, rmse: float) -> Finished:
    return Finished(case, REFERENCE, NO_TRACE, {window: {"rmse": rmse} for window in Window})


def test_a_law_of_which_one_run_failed_has_no_numbers() -> None:
    runs = [
        finished(Case("sensing_circle", law=law, seed=seed), rmse)
        for law, values in PAPER_LIKE.items()
        for seed, rmse in enumerate(values)
    ]
    [whole] = sensing_summary(runs, ())
    assert whole.ordered
    [broken] = sensing_summary(runs, (Failure(Case("sensing_circle", law="rod6", seed=2), "FAULT"),))
    assert [law.law for law in broken.laws] == ["ff", "rod10", "rod6+10"] and not broken.ordered
    [nothing] = sensing_summary((), [Failure(Case("sensing_sweep", law=law), "FAULT") for law in PAPER_LIKE])
    assert (nothing.laws, nothing.ordered) == ((), False)


@pytest.mark.parametrize(
    ("ff", "rod6", "rod10", "both", "ordered"),
    [
        (4.0, 3.0, 2.0, 2.5, True),
        (4.0, 3.0, 2.0, 2.0 / (1.0 + 0.9 * EQUAL), True),
        (4.0, 3.0, 2.0, 2.0 / (1.0 + 1.1 * EQUAL), False),
        (4.0, 2.0, 3.0, 3.0, False),
        (3.0, 4.0, 2.0, 2.0, False),
        (4.0, 3.0, 2.0, 4.5, False),
        (4.0, 4.0 * (1.0 - 1.1 * CLEARLY), 2.0, 2.5, True),
        (4.0, 4.0 * (1.0 - 0.9 * CLEARLY), 2.0, 2.5, False),
    ],
)
def test_the_order_is_ff_worst_rod_6_clearly_better_and_the_tip_best_or_equal(
    ff: float, rod6: float, rod10: float, both: float, ordered: bool
) -> None:
    assert in_order({"ff": ff, "rod6": rod6, "rod10": rod10, "rod6+10": both}) is ordered


def test_welch_is_the_textbooks_formula() -> None:
    a, b = (1.0, 2.0, 4.0), (3.0, 5.0, 9.0, 7.0)
    mean_a, mean_b, var_a, var_b = 7 / 3, 6.0, 7 / 3 / 3, 20 / 3 / 4
    freedom = (var_a + var_b) ** 2 / (var_a**2 / 2 + var_b**2 / 3)
    expected = 2.0 * t.sf(abs(mean_a - mean_b) / math.sqrt(var_a + var_b), freedom)
    assert welch(a, b) == pytest.approx(float(expected))
    assert welch((1.0,), b) is None
