"""The twin's number for each row of the paper, and how far it is off on the scale of the fit."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from controller.arrays import Array, Rows
from controller.reference.reference import Reference
from controller.research.calibration.scales import scale_of
from controller.research.experiments.paper_rows import DIGITS, PaperRow, window_of
from controller.schema.modes import Mode
from controller.schema.parameters import RigParameters, Settings
from controller.simulation import run
from controller.simulation.case import Case, Setup, parameters_of, planned, settings_of
from controller.simulation.metrics import UNITS, measure, reduction

BROKEN = 30.0
"""Residual of a run that broke off at its very end; twice as much at its start. A bad run that lasts stays below."""


class Attempt(NamedTuple):
    """A run that may have been broken off by the rig."""

    rows: Rows
    """Telemetry (n,), one row a tick of the reference."""
    lasted: float
    """Share of it that was in TRACK."""


Predicted = tuple[float, float]
"""Our number (nan if a run broke off), and the share of its runs that lasted."""


def attempt(parameters: RigParameters, planned: Reference, settings: Settings, seed: int) -> Attempt:
    """`run`, but a run that is broken off is a result as well."""
    rows = run.attempt(parameters, planned, settings, seed)
    broken = np.flatnonzero(rows["mode"] != Mode.TRACK)
    return Attempt(rows, float(broken[0]) / len(rows) if broken.size else 1.0)


def predict(paper_rows: Iterable[PaperRow], setup: Setup, seed: int = 0) -> list[Predicted]:
    """Our number for each row, in its unit; every run is made once, whatever the number of rows about it."""
    paper_rows = list(paper_rows)
    cases = dict.fromkeys(case for row in paper_rows for case in cases_of(row, seed))
    metrics = {case: metrics_of(case, setup) for case in cases}
    return [predicted(row, [metrics[case] for case in cases_of(row, seed)]) for row in paper_rows]


def cases_of(row: PaperRow, seed: int) -> list[Case]:
    """The runs that a row is about: one, the ten digits, or that of FF before the one that reduces its error."""
    names: Sequence[str] = DIGITS if row.experiment == "digits" else (row.experiment,)
    laws = ("ff", row.law) if row.metric == "reduction" else (row.law,)
    return [Case(name, row.actuator, law, seed) for name in names for law in laws]


def metrics_of(case: Case, setup: Setup) -> tuple[Mapping[str, float], float]:
    """Metrics of a run in the paper's window (none if it broke off), and the share of it that lasted."""
    path = planned(case.reference, case.actuator, setup.controller)
    rows, lasted = attempt(parameters_of(case, setup), path, settings_of(case, setup.gains), case.seed)
    return (measure(rows, path, window_of(case.reference)) if lasted == 1.0 else {}), lasted


def predicted(row: PaperRow, runs: Sequence[tuple[Mapping[str, float], float]]) -> Predicted:
    """Mean over the runs of a row, or by how much the second one's error is below the first one's."""
    metric = "rmse" if row.metric == "reduction" else row.metric
    numbers = [metrics.get(metric, math.nan) for metrics, _ in runs]
    ours = UNITS["reduction"][1] * reduction(*numbers) if row.metric == "reduction" else float(np.mean(numbers))
    return ours, float(np.mean([lasted for _, lasted in runs]))


def row_residual(row: PaperRow, ours: Predicted) -> float:
    """How far our number is off the paper's, in standard deviations of the fit; large, but finite, without a number."""
    number, lasted = ours
    if row.paper is None or not math.isfinite(number):
        return BROKEN * (2.0 - lasted)
    ours_at, paper_at = scale_of(row.metric).place(np.array([number, row.paper]))
    return float(ours_at - paper_at)


def row_residuals(paper_rows: Sequence[PaperRow], ours: Sequence[Predicted]) -> Array:
    """`row_residual` of each row (n,)."""
    return np.array([row_residual(row, number) for row, number in zip(paper_rows, ours, strict=True)])
