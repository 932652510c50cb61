"""From finished runs to rows: ours beside the paper's number, a mean over the seeds."""

from collections.abc import Iterable, Sequence
from dataclasses import asdict
from statistics import mean, stdev
from typing import NamedTuple

from controller.reference.library import SWEEP
from controller.research.experiments.catalogue import CASES
from controller.research.experiments.paper_rows import DIGITS, FEEDBACK_SHARE, PAPER_ROWS, paper_row, window_of
from controller.research.experiments.results import Failure, Finished, ResultRow, SweepPoint
from controller.simulation.case import Case
from controller.simulation.metrics import UNITS, Window, reduction

SWEEP_HZ = 2.0
"""The frequency sweep's one row is the share at this frequency, the upper of the two that the paper gives."""
ALWAYS = ("rmse", "ise", "max_x", "max_y", "observer_rmse", "feedback_share")
"""Metrics of every run: what a run that failed would have had at least."""

Metrics = dict[Window, dict[str, float]]


class Runs(NamedTuple):
    """All runs of one case, a run a seed."""

    experiment: str
    actuator: str
    law: str
    metrics: Sequence[Metrics]
    failures: Sequence[str]
    """Why the others did not come to their end."""


def result_rows(
    outcomes: Sequence[Finished], failures: Sequence[Failure], sweep: Sequence[SweepPoint]
) -> tuple[ResultRow, ...]:
    """Every row, in the order of the catalogue; (experiment, actuator, law, metric) is unique."""
    found: list[ResultRow] = []
    for case in CASES:
        runs = runs_of(case, outcomes, failures)
        if case.reference not in SWEEP and (runs.metrics or runs.failures):
            found += rows(runs)
            if case.law == "rod6":
                found += reductions(runs_of(Case(case.reference, law="ff"), outcomes, failures), runs)
            if case.reference == DIGITS[-1]:
                found += rows(digits(outcomes, failures))
    return (*found, *sweep_rows(sweep))


def runs_of(case: Case, outcomes: Iterable[Finished], failures: Iterable[Failure]) -> Runs:
    """The runs of `case`, whatever their seeds."""
    wanted = case.reference, case.actuator, case.law
    metrics = [one.metrics for one in outcomes if _about(one.case) == wanted]
    return Runs(*wanted, metrics, [one.sentence for one in failures if _about(one.case) == wanted])


def digits(outcomes: Sequence[Finished], failures: Sequence[Failure]) -> Runs:
    """The ten digits as one experiment: every metric of a seed is the mean over them (paper, summary table)."""
    each = [runs_of(Case(digit), outcomes, failures) for digit in DIGITS]
    same_seed = zip(*(runs.metrics for runs in each), strict=False)
    return Runs(
        "digits", "P1", "ff+pi", [_mean(metrics) for metrics in same_seed], [f for r in each for f in r.failures]
    )


def reductions(ff: Runs, runs: Runs) -> list[ResultRow]:
    """By how much the sensors of `runs` take down FF's error, seed by seed; if they failed, `rows` has said so."""
    if runs.failures:
        return []
    if ff.failures:
        return [_failed(runs._replace(failures=ff.failures), "reduction")]
    pairs = zip(ff.metrics, runs.metrics, strict=False)
    found = [_reduced(before, after) for before, after in pairs]
    return rows(runs._replace(metrics=found)) if found else []


def rows(runs: Runs) -> list[ResultRow]:
    """A row for each metric. If one run was broken off there is no number: the others would flatter it."""
    if runs.failures:
        return [_failed(runs, metric) for metric in expected(runs)]
    window = window_of(runs.experiment)
    return [_row(runs, metric, window) for metric in UNITS if all(metric in one[window] for one in runs.metrics)]


def expected(runs: Runs) -> list[str]:
    """Metrics that `runs` would have had: those of every run, and those that the paper gives."""
    about = runs.experiment, runs.actuator, runs.law
    named = {row.metric for row in PAPER_ROWS if row.key[:3] == about}
    return [metric for metric in UNITS if metric in named or metric in ALWAYS]


def sweep_rows(sweep: Sequence[SweepPoint]) -> list[ResultRow]:
    """The frequency sweep as one row, with its curve. The paper names neither shape nor actuator: no `paper` number."""
    about = paper_row("frequency_sweep", "P1", "ff+pi", "feedback_share")
    extra = {
        "frequency_hz": SWEEP_HZ,
        "curve": [asdict(point) for point in sweep],
        "paper_curve": [{"frequency": f, "share": share} for f, share in FEEDBACK_SHARE.items()],
        "note": f"the share at {SWEEP_HZ:g} Hz; the paper gives paper_curve, but neither shape nor actuator",
    }
    window = window_of("frequency_sweep")
    return [
        ResultRow(about, point.share, point.share_std, window, None, point.seeds, point.failed, extra=extra)
        for point in sweep
        if point.frequency == SWEEP_HZ
    ]


def _row(runs: Runs, metric: str, window: Window) -> ResultRow:
    other = next(one for one in Window if one is not window)
    values = [metrics[window][metric] for metrics in runs.metrics]
    elsewhere = [metrics[other][metric] for metrics in runs.metrics if metric in metrics[other]]
    return ResultRow(
        about=paper_row(runs.experiment, runs.actuator, runs.law, metric),
        ours=mean(values),
        ours_std=stdev(values) if len(values) > 1 else None,
        window=window,
        ours_other_window=mean(elsewhere) if elsewhere else None,
        seeds=len(values),
    )


def _failed(runs: Runs, metric: str) -> ResultRow:
    about = paper_row(runs.experiment, runs.actuator, runs.law, metric)
    count = len(runs.metrics) + len(runs.failures)
    said = runs.failures[0] if count == 1 else f"{len(runs.failures)} of {count} runs: {runs.failures[0]}"
    return ResultRow(about, None, None, window_of(runs.experiment), None, count, said)


def _mean(metrics: Sequence[Metrics]) -> Metrics:
    """Each metric's mean over several runs that all have it."""
    return {
        window: {name: mean(one[window][name] for one in metrics) for name in metrics[0][window]} for window in Window
    }


def _reduced(before: Metrics, after: Metrics) -> Metrics:
    """The reduction from one run to another, in both windows, as the only metric."""
    unit = UNITS["reduction"][1]
    return {one: {"reduction": unit * reduction(before[one]["rmse"], after[one]["rmse"])} for one in Window}


def _about(case: Case) -> tuple[str, str, str]:
    return case.reference, case.actuator, case.law
