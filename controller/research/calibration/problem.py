"""One point of the search, evaluated: rows, priors and margins as residuals of one sum of squares."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from controller.arrays import Array
from controller.errors import TendrilError
from controller.research.calibration.margins import TRIALS, Margin, Trial, measure_margins
from controller.research.calibration.predictions import Predicted, predict, row_residuals
from controller.research.calibration.space import Space
from controller.research.experiments.paper_rows import FITTED, PaperRow

T = TypeVar("T")
HOPELESS = 300.0
"""Cost of rows and priors from which a point of the screening is not asked for its margins."""


@dataclass(frozen=True)
class Problem:
    """What is searched for, and by what it is judged."""

    space: Space = field(default_factory=Space)
    rows: tuple[PaperRow, ...] = FITTED
    trials: tuple[Trial, ...] = TRIALS
    seed: int = 0
    """Of the twin's noise, in all runs."""


@dataclass(frozen=True)
class Evaluation:
    """What came of one point."""

    z: Array
    """(n,) in the unit cube."""
    predicted: tuple[Predicted, ...]
    """Our numbers, in the order of the problem's rows."""
    margins: tuple[Margin, ...]
    """Empty for a hopeless point."""
    residuals: Array
    """Rows, priors, margins, in this order; without the margins of a hopeless point."""
    trouble: str = ""
    """Why something could not even be begun."""

    @property
    def cost(self) -> float:
        """Half the sum of squares, as scipy's least squares counts."""
        return 0.5 * float(np.sum(self.residuals**2))


def evaluate(problem: Problem, z: Array, hopeless: float = np.inf) -> Evaluation:
    """Run everything at z (n,), but not the margins if rows and priors cost more than `hopeless`."""
    setup = problem.space.decode(z)
    none = [(math.nan, 0.0)] * len(problem.rows)
    ours, trouble = attempted(lambda: predict(problem.rows, setup, problem.seed), none)
    residuals = np.concatenate([row_residuals(problem.rows, ours), problem.space.prior_residuals(z)])
    margins: tuple[Margin, ...] = ()
    if 0.5 * float(np.sum(residuals**2)) <= hopeless:
        broken = tuple(Margin(trial, math.nan, math.nan, 0.0) for trial in problem.trials)
        margins, more = attempted(lambda: measure_margins(problem.trials, setup, problem.seed), broken)
        trouble = trouble or more
    penalties = np.array([margin.penalty for margin in margins])
    return Evaluation(z, tuple(ours), margins, np.concatenate([residuals, penalties]), trouble)


def attempted(work: Callable[[], T], otherwise: T) -> tuple[T, str]:
    """What `work` gives, or `otherwise` and why: a plant that cannot be run is a bad point, not the end of a search."""
    try:
        return work(), ""
    except (TendrilError, np.linalg.LinAlgError) as error:
        return otherwise, str(error)


def keeps_margins(problem: Problem, found: Evaluation) -> bool:
    """Whether the loop stayed stable in every trial."""
    return not found.trouble and len(found.margins) == len(problem.trials) and all(one.kept for one in found.margins)
