"""Task 4: what sensing a rod in the middle, the tip or both is worth, as the paper reports it."""

from collections.abc import Sequence

from scipy.stats import ttest_ind

from controller.experiments.paper_rows import SENSING, SENSING_LAWS, SENSING_REDUCTION, window_of
from controller.experiments.results import Finished, SensedLaw, SensedTrajectory, SensingSummary

EQUAL = 0.05
"""Means that differ by less than this share count as equal (ours). Only the camera's noise differs from run to run of
the twin, so the t test, which is reported beside, finds differences that no rig would show."""


def sensing_summary(outcomes: Sequence[Finished]) -> SensingSummary:
    """Each trajectory of Task 4 on which anything came to its end."""
    found = []
    for experiment in SENSING:
        rmse = {law: _rmse(outcomes, experiment, law) for law in SENSING_LAWS}
        if present := {law: values for law, values in rmse.items() if values}:
            found.append(summarised(experiment, present))
    return tuple(found)


def summarised(experiment: str, rmse: dict[str, tuple[float, ...]]) -> SensedTrajectory:
    """The trajectory `experiment` from the RMSE [mm] of all runs of each law that has any."""
    largest = max(max(values) for values in rmse.values())
    means = {law: sum(values) / len(values) for law, values in rmse.items()}
    p_value = welch(rmse.get("rod10", ()), rmse.get("rod6+10", ()))
    worst = means.get("ff", float("nan"))
    laws = tuple(
        SensedLaw(law, values, tuple(value / largest for value in values), 1.0 - means[law] / worst)
        for law, values in rmse.items()
    )
    return SensedTrajectory(experiment, laws, SENSING_REDUCTION[experiment], in_order(means), p_value)


def in_order(means: dict[str, float]) -> bool:
    """FF worst, rod 6 better, rod 10 best or equal with rods 6+10."""
    if set(means) != set(SENSING_LAWS):
        return False
    ff, rod6, rod10, both = (means[law] for law in SENSING_LAWS)
    return ff > rod6 > rod10 and ff > both and rod10 <= both * (1.0 + EQUAL)


def welch(a: Sequence[float], b: Sequence[float]) -> float | None:
    """Two-sided p of Welch's t test; None with fewer than two values on a side."""
    if min(len(a), len(b)) < 2:
        return None
    return float(ttest_ind(a, b, equal_var=False).pvalue)


def _rmse(outcomes: Sequence[Finished], experiment: str, law: str) -> tuple[float, ...]:
    """RMSE [mm] of each run, in the paper's window."""
    window = window_of(experiment)
    runs = (one for one in outcomes if (one.case.reference, one.case.law) == (experiment, law))
    return tuple(one.metrics[window]["rmse"] for one in runs)
