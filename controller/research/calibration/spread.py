"""What the near-equal fits say of every row of the paper: the interval in which they put it.

It is as wide as three things make it: what the fit rows leave open (the fits), what another print does (P2 and P3), and
what no fit of this form explains (the discrepancy).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import norm

from controller.arrays import Array
from controller.research.calibration.predictions import Predicted, predict
from controller.research.calibration.prints import FITTED_PRINT, another_print
from controller.research.calibration.problem import Evaluation, Problem
from controller.research.calibration.scales import scale_of
from controller.research.experiments.paper_rows import ACTUATORS, FIT, PREDICTED, PaperRow
from controller.research.experiments.pool import Pool
from controller.simulation.case import Setup

INTERVAL = (5.0, 95.0)
"""Percentiles of the numbers that bound an interval (docs/conventions.md)."""
PRINTS = 4
"""Prints of P2 and of P3 that are drawn for each near-equal fit: a tail of two dozen numbers is hardly one."""
NORMAL: Array = norm.ppf((np.arange(99) + 0.5) / 99)
"""A standard normal distribution as evenly likely numbers (99,)."""
Call = tuple[tuple[PaperRow, ...], Setup, int]
"""Arguments of `predict`."""


@dataclass(frozen=True)
class RowSpread:
    """A row under the near-equal fits; nan where a run broke off."""

    row: PaperRow
    best: float
    """Of the chosen fit."""
    low: float
    """Lower end of the interval."""
    median: float
    high: float
    """Upper end of the interval."""
    numbers: int
    """How many there are: one a fit, and of another actuator than the fitted one a few more."""

    @property
    def inside(self) -> bool:
        """Whether the paper's number is in the interval."""
        return self.row.paper is not None and self.low <= self.row.paper <= self.high


def intervals(
    problem: Problem, fits: Sequence[Evaluation], pool: Pool, done: Callable[[list[Predicted]], None]
) -> list[RowSpread]:
    """Each row that was fitted, and each of PREDICTED. Called only once the fits are chosen, the best first."""
    numbers: dict[PaperRow, list[float]] = {row: [] for row in (*problem.rows, *PREDICTED)}
    calls = predictions(problem, fits)
    told = [(problem.rows, fit.predicted) for fit in fits]
    told += [(rows, tuple(ours)) for (rows, *_), ours in zip(calls, pool.map(predict, calls, done), strict=True)]
    for rows, ours in told:
        for row, (number, _) in zip(rows, ours, strict=True):
            numbers[row].append(number)
    size = discrepancy(problem.rows, fits)
    return [row_spread(row, np.array(found), size) for row, found in numbers.items()]


def predictions(problem: Problem, fits: Sequence[Evaluation]) -> list[Call]:
    """The runs of PREDICTED: under every fit, the best first. Other actuators than the fitted one are other prints."""
    calls = [_call(problem, FITTED_PRINT, fit.z) for fit in fits]
    for number, actuator in enumerate(ACTUATORS):
        if actuator != FITTED_PRINT:
            seeds = [(problem.seed, number, i, j) for i in range(len(fits)) for j in range(PRINTS)]
            drawn = [another_print(problem.space, fits[seed[2]].z, seed) for seed in seeds]
            calls += [_call(problem, actuator, z) for z in (fits[0].z, *drawn)]
    return [call for call in calls if call[0]]


def _call(problem: Problem, actuator: str, z: Array) -> Call:
    rows = tuple(row for row in PREDICTED if row.actuator == actuator)
    return rows, problem.space.decode(z), problem.seed


def discrepancy(rows: Sequence[PaperRow], fits: Sequence[Evaluation]) -> float:
    """By how much the paper is further off the fits than these are off one another, rms over the rows, on their scales.

    Were it drawn with this deviation, the rows would be as far off the middle of the fits as they are.
    """
    found = []
    for row, *ours in zip(rows, *(fit.predicted for fit in fits), strict=True):
        there = np.array([number for number, _ in ours if math.isfinite(number)])
        if there.size and row.paper is not None:
            off = scale_of(row.metric).place(there) - scale_of(row.metric).place(np.array([row.paper]))
            found.append(float(off.mean() ** 2 - off.var()))
    return math.sqrt(max(0.0, float(np.mean(found)))) if found else 0.0


def row_spread(row: PaperRow, numbers: Array, size: float) -> RowSpread:
    """Interval and middle of the numbers (n,), the best fit's first, each with a discrepancy of `size` about it."""
    there, scale = numbers[np.isfinite(numbers)], scale_of(row.metric)
    about = scale.numbers(np.add.outer(scale.place(there), size * NORMAL))
    low, median, high = np.percentile(about, (INTERVAL[0], 50.0, INTERVAL[1])) if there.size else (np.nan,) * 3
    return RowSpread(row, float(numbers[0]), float(low), float(median), float(high), there.size)


def coverage(spread: Sequence[RowSpread]) -> tuple[int, int]:
    """How many of the fit rows have the paper's number in their interval, and how many there are."""
    inside = [one.inside for one in spread if one.row.role == FIT]
    return sum(inside), len(inside)
