"""One point of the search, evaluated: rows, priors and margins as residuals of one sum of squares."""

from dataclasses import dataclass, field

import numpy as np

from controller.calibration.margins import TRIALS, Margin, Trial, measure_margins
from controller.calibration.predictions import Predicted, predict, row_residuals
from controller.calibration.space import Space
from controller.experiments.paper_rows import FITTED, PaperRow
from controller.kernels.rod import Array

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

    @property
    def cost(self) -> float:
        """Half the sum of squares, as scipy's least squares counts."""
        return 0.5 * float(np.sum(self.residuals**2))


def evaluate(problem: Problem, z: Array, hopeless: float = np.inf) -> Evaluation:
    """Run everything at z (n,), but not the margins if rows and priors cost more than `hopeless`."""
    setup = problem.space.decode(z)
    ours = predict(problem.rows, setup, problem.seed)
    residuals = np.concatenate([row_residuals(problem.rows, ours), problem.space.prior_residuals(z)])
    margins: tuple[Margin, ...] = ()
    if 0.5 * float(np.sum(residuals**2)) <= hopeless:
        margins = measure_margins(problem.trials, setup, problem.seed)
    penalties = np.array([margin.penalty for margin in margins])
    return Evaluation(z, tuple(ours), margins, np.concatenate([residuals, penalties]))


def keeps_margins(problem: Problem, found: Evaluation) -> bool:
    """Whether the loop stayed stable in every trial."""
    return len(found.margins) == len(problem.trials) and all(margin.kept for margin in found.margins)
