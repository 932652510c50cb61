"""The frequency sweep: how much of the command is feedback, and how far the tip lags, from slow to fast."""

from collections.abc import Sequence
from statistics import mean, stdev

from controller.experiments.catalogue import SWEEP
from controller.experiments.metrics import Window
from controller.experiments.paper_rows import FEEDBACK_SHARE
from controller.experiments.results import Failure, Finished, SweepPoint
from controller.reference.library import SWEPT_HZ


def frequency_sweep(outcomes: Sequence[Finished], failures: Sequence[Failure]) -> tuple[SweepPoint, ...]:
    """A point for each frequency that was run, finished or not; measured after the approach, which has no frequency."""
    points = []
    for name, frequency in zip(SWEEP, SWEPT_HZ, strict=True):
        runs = [one for one in outcomes if one.case.reference == name]
        broken = [one for one in failures if one.case.reference == name]
        if runs or broken:
            points.append(sweep_point(frequency, runs, broken))
    return tuple(points)


def sweep_point(frequency: float, runs: Sequence[Finished], broken: Sequence[Failure]) -> SweepPoint:
    """The runs at `frequency` [Hz]; if one was broken off, those that were not do not stand for it."""
    paper, count = FEEDBACK_SHARE.get(frequency), len(runs) + len(broken)
    if broken:
        return SweepPoint(frequency, None, None, None, (None, None), paper, broken[0].sentence, count)
    share, rmse = _values(runs, "feedback_share"), _values(runs, "rmse")
    lag_x, lag_y = (_values(runs, f"lag_deg_{axis}") for axis in "xy")
    return SweepPoint(
        frequency=frequency,
        share=mean(share),
        share_std=stdev(share) if count > 1 else None,
        rmse=mean(rmse),
        lag_deg=(mean(lag_x) if lag_x else None, mean(lag_y) if lag_y else None),
        paper=paper,
        seeds=count,
    )


def _values(runs: Sequence[Finished], metric: str) -> list[float]:
    """Of the runs that have it: a tip that hardly swings has no lag."""
    found = (run.metrics[Window.AFTER_APPROACH].get(metric) for run in runs)
    return [value for value in found if value is not None]
