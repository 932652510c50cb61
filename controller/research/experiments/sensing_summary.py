"""Task 4: what sensing a rod in the middle, the tip or both is worth, as the paper reports it."""

from collections.abc import Sequence

from scipy.stats import ttest_ind

from controller.research.experiments.paper_rows import SENSING, SENSING_LAWS, SENSING_REDUCTION, window_of
from controller.research.experiments.results import Failure, Finished, SensedLaw, SensedTrajectory, SensingSummary
from controller.simulation.metrics import reduction

EQUAL = 0.05
"""Means that differ by less than this share count as equal (ours). Only the camera's noise differs from run to run of
the twin, so the t test, which is reported beside, finds differences that no rig would show."""
CLEARLY = 0.1
"""Rod 6 is clearly better than FF if it takes at least this share off its mean (ours; in the paper 27 % or more)."""


def sensing_summary(outcomes: Sequence[Finished], failures: Sequence[Failure]) -> SensingSummary:
    """Each trajectory of Task 4 that was run; a law of which any run was broken off has no numbers."""
    broken = {(one.case.reference, one.case.law) for one in failures}
    found = []
    for experiment in SENSING:
        rmse = {law: _rmse(outcomes, experiment, law) for law in SENSING_LAWS}
        whole = {law: values for law, values in rmse.items() if values and (experiment, law) not in broken}
        if whole or any((experiment, law) in broken for law in SENSING_LAWS):
            found.append(summarised(experiment, whole))
    return tuple(found)


def summarised(experiment: str, rmse: dict[str, tuple[float, ...]]) -> SensedTrajectory:
    """The trajectory `experiment` from the RMSE [mm] of all runs of each law that has any."""
    largest = max((value for values in rmse.values() for value in values), default=float("nan"))
    means = {law: sum(values) / len(values) for law, values in rmse.items()}
    p_value = welch(rmse.get("rod10", ()), rmse.get("rod6+10", ()))
    worst = means.get("ff", float("nan"))
    laws = tuple(
        SensedLaw(law, values, tuple(value / largest for value in values), reduction(worst, means[law]))
        for law, values in rmse.items()
    )
    return SensedTrajectory(experiment, laws, SENSING_REDUCTION[experiment], in_order(means), p_value)


def in_order(means: dict[str, float]) -> bool:
    """FF worst, rod 6 clearly better, rod 10 best or equal with rods 6+10."""
    if set(means) != set(SENSING_LAWS):
        return False
    ff, rod6, rod10, both = (means[law] for law in SENSING_LAWS)
    return (1.0 - CLEARLY) * ff >= rod6 > rod10 and ff > both and rod10 <= both * (1.0 + EQUAL)


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
