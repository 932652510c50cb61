"""What the near-equal fits say of every row of the paper: the interval in which they put it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from controller.arrays import Array
from controller.research.calibration.predictions import Predicted, predict
from controller.research.calibration.problem import Evaluation, Problem
from controller.research.experiments.paper_rows import PREDICTED, PaperRow
from controller.research.experiments.pool import Pool

INTERVAL = (5.0, 95.0)
"""Percentiles of the fits' numbers that bound an interval (docs/conventions.md)."""


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
    fits: int
    """How many of them gave a number."""

    @property
    def inside(self) -> bool:
        """Whether the paper's number is in the interval."""
        return self.row.paper is not None and self.low <= self.row.paper <= self.high


def intervals(
    problem: Problem, fits: Sequence[Evaluation], pool: Pool, done: Callable[[list[Predicted]], None]
) -> list[RowSpread]:
    """Each row that was fitted, and each of PREDICTED, under every fit. Called only once the fits are chosen."""
    fitted = np.array([[number for number, _ in fit.predicted] for fit in fits])
    calls = [(PREDICTED, problem.space.decode(fit.z), problem.seed) for fit in fits]
    others = np.array([[number for number, _ in ours] for ours in pool.map(predict, calls, done)])
    rows = zip((*problem.rows, *PREDICTED), (*fitted.T, *others.T), strict=True)
    return [row_spread(row, column) for row, column in rows]


def row_spread(row: PaperRow, numbers: Array) -> RowSpread:
    """Interval and middle of the numbers (fits,), the best fit's first."""
    there = numbers[np.isfinite(numbers)]
    low, median, high = np.percentile(there, (INTERVAL[0], 50.0, INTERVAL[1])) if there.size else (np.nan,) * 3
    return RowSpread(row, float(numbers[0]), float(low), float(median), float(high), there.size)
