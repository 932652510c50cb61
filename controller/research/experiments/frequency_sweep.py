"""The frequency sweep: how much of the command is feedback, and how far the tip lags, from slow to fast."""

from collections.abc import Sequence
from dataclasses import replace
from statistics import mean, stdev

from controller.reference.library import SWEEP
from controller.research.experiments.campaign import Job
from controller.research.experiments.paper_rows import FEEDBACK_SHARE
from controller.research.experiments.results import Failure, Finished, SweepPoint
from controller.simulation.case import Case, Setup
from controller.simulation.metrics import Window


def jobs_without_k_ff(cases: Sequence[Case], setup: Setup) -> tuple[Job, ...]:
    """The sweep's cases with the first seed again, with K_FF = 0: what is left of the feedback is PI."""
    first = min(case.seed for case in cases)
    changed = Setup(setup.twin, setup.controller, setup.gains.model_copy(update={"K_FF": (0.0, 0.0)}))
    return tuple(Job(case, changed) for case in cases if case.reference in SWEEP and case.seed == first)


def frequency_sweep(
    outcomes: Sequence[Finished], failures: Sequence[Failure], without_k_ff: Sequence[Finished] = ()
) -> tuple[SweepPoint, ...]:
    """A point for each frequency that was run, finished or not; measured after the approach, which has no frequency."""
    points = []
    alone = {one.case.reference: one.metrics[Window.AFTER_APPROACH]["feedback_share"] for one in without_k_ff}
    for name, frequency in SWEEP.items():
        runs = [one for one in outcomes if one.case.reference == name]
        broken = [one for one in failures if one.case.reference == name]
        if runs or broken:
            points.append(replace(sweep_point(frequency, runs, broken), share_pi=alone.get(name)))
    return tuple(points)


def sweep_point(frequency: float, runs: Sequence[Finished], broken: Sequence[Failure]) -> SweepPoint:
    """The runs at `frequency` [Hz]; if one was broken off, those that were not do not stand for it."""
    paper, count = FEEDBACK_SHARE.get(frequency), len(runs) + len(broken)
    if broken:
        return SweepPoint(frequency, None, None, None, None, (None, None), paper, broken[0].sentence, count)
    share, rmse = _values(runs, "feedback_share"), _values(runs, "rmse")
    lag_x, lag_y = (_values(runs, f"lag_deg_{axis}") for axis in "xy")
    return SweepPoint(
        frequency=frequency,
        share=mean(share),
        share_std=stdev(share) if count > 1 else None,
        share_pi=None,
        rmse=mean(rmse),
        lag_deg=(mean(lag_x) if lag_x else None, mean(lag_y) if lag_y else None),
        paper=paper,
        seeds=count,
    )


def _values(runs: Sequence[Finished], metric: str) -> list[float]:
    """Of the runs that have it: a tip that hardly swings has no lag."""
    found = (run.metrics[Window.AFTER_APPROACH].get(metric) for run in runs)
    return [value for value in found if value is not None]
