"""What other gains would give the observer on Task 2's fast runs (paper: K_o = 100 N/m, B_o = 0)."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from controller.research.experiments.campaign import Job, Run
from controller.research.experiments.results import Finished, ObserverGain
from controller.simulation.case import Case, Setup
from controller.simulation.metrics import Window


class ObserverChoice(NamedTuple):
    """An observer."""

    B_o: float
    """[N s/m]."""
    K_o: float
    """[N/m]."""
    carry_on: bool
    """Whether a marker is carried on to the present (ours) or held."""


CASES = ("circle_1hz", "vertical_1hz", "horizontal_1hz")
TRIED = (
    ObserverChoice(0.0, 100.0, False),
    ObserverChoice(0.0, 200.0, True),
    ObserverChoice(0.0, 400.0, True),
    ObserverChoice(1.0, 100.0, True),
)
"""Beside the setup's own. The first, which is the paper's, is all that a quick reproduction tries, on the circle."""


def observer_jobs(cases: Sequence[Case], setup: Setup, quick: bool) -> tuple[Job, ...]:
    """TRIED on the first seed of those of CASES that are run anyway, P1 under FF+PI."""
    seed = min(case.seed for case in cases)
    among = [case for name in CASES if (case := Case(name, seed=seed)) in cases]
    choices, among = (TRIED[:1], among[:1]) if quick else (TRIED, among)
    return tuple(Job(case, with_observer(setup, choice)) for choice in choices for case in among)


def with_observer(setup: Setup, choice: ObserverChoice) -> Setup:
    """`setup` with another observer."""
    gains = setup.gains.model_copy(update={"K_o": (choice.K_o,) * 2, "B_o": (choice.B_o,) * 2})
    return Setup(setup.twin, setup.controller.model_copy(update={"carry_on": choice.carry_on}), gains)


def observer_of(setup: Setup) -> ObserverChoice:
    """The observer of `setup`."""
    return ObserverChoice(setup.gains.B_o[0], setup.gains.K_o[0], setup.controller.carry_on)


def observer_gains(
    jobs: Sequence[Job], runs: Sequence[Run], setup: Setup, own: Sequence[Run]
) -> tuple[ObserverGain, ...]:
    """The error at the tip with each observer: `runs` are those of `jobs`, `own` among others those on `setup`."""
    found: dict[ObserverChoice, dict[str, float]] = {}
    for job, run in zip(jobs, runs, strict=True):
        found.setdefault(observer_of(job.setup), {})[run.case.reference] = observer_rmse(run)
    if found:
        by_case = {run.case: run for run in own}
        found[observer_of(setup)] = {job.case.reference: observer_rmse(by_case[job.case]) for job in jobs}
    return tuple(ObserverGain(one.K_o, one.B_o, one.carry_on, found[one]) for one in sorted(found))


def observer_rmse(run: Run) -> float:
    """Observer's tip against the true one over the whole run [mm]; nan for a run that the rig broke off."""
    return run.metrics[Window.WHOLE]["observer_rmse"] if isinstance(run, Finished) else math.nan
