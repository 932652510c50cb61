"""What ten numbers leave open: the fits nearly as good as the best, and how their predictions of other rows differ."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from controller.arrays import Array
from controller.research.calibration.predictions import Predicted, predict
from controller.research.calibration.problem import Evaluation, Problem, keeps_margins
from controller.research.calibration.search import Search, Stage, distance
from controller.research.experiments.paper_rows import JUDGED, PaperRow
from controller.research.experiments.pool import Pool

NEAR = 2.0
"""By how much more a near-equal fit may cost: two standard deviations along any one line through the best."""
FITS, FITS_MIN = 16, 8
"""Near-equal fits that are wanted, and below which the spread says little."""
APART = 0.03
"""Two fits are no nearer than this, rms over the cube: neighbours of one Jacobian are one fit."""
PROPOSALS, ROUNDS = 8, 15
"""Points of one round of the walk, and its rounds at most."""
FIRST_SCALE = 0.06
"""Of the walk's steps at first, rms over the cube."""
STAGE = Stage("near-equal fits", PROPOSALS * ROUNDS)


@dataclass(frozen=True)
class RowSpread:
    """A held-out row under the near-equal fits; nan where a run broke off."""

    row: PaperRow
    best: float
    """Of the chosen fit."""
    low: float
    median: float
    high: float
    fits: int
    """How many of them gave a number."""


def near_equal(search: Search, best: Evaluation) -> list[Evaluation]:
    """The best fit first, then those within NEAR that keep the margins, the farthest apart first, at most FITS."""
    near = (one for one in search.found if is_near(search.problem, one, best))
    close = sorted(near, key=lambda one: one.z.tobytes())  # they were found in any order
    chosen = [best]
    while len(chosen) < FITS:
        gaps = [min(distance(one, other) for other in chosen) for one in close]
        if not gaps or max(gaps) < APART:
            break
        chosen.append(close[int(np.argmax(gaps))])
    return chosen


def is_near(problem: Problem, one: Evaluation, best: Evaluation) -> bool:
    """Whether `one` is as good a fit as `best`, for all that the rows say."""
    return one.cost <= best.cost + NEAR and keeps_margins(problem, one)


def walk(search: Search, best: Evaluation, seed: int) -> None:
    """Evaluate points around the near-equal fits until there are enough; the steps follow what is accepted.

    Raises OutOfTime when the budget is spent.
    """
    random, scale = np.random.default_rng(seed), FIRST_SCALE
    for _ in range(ROUNDS):
        fits = near_equal(search, best)
        if len(fits) >= FITS:
            return
        points = [proposal(fits, scale, random) for _ in range(PROPOSALS)]
        tried = search.evaluate(points, STAGE)
        accepted = sum(is_near(search.problem, one, best) for one in tried)
        scale *= 0.6 if accepted == 0 else 1.3 if accepted > PROPOSALS // 2 else 1.0


def proposal(fits: Sequence[Evaluation], scale: float, random: np.random.Generator) -> Array:
    """A point near one of the fits, and along the line between two others, in the box."""
    one, a, b = (fits[i].z for i in random.integers(len(fits), size=3))
    moved: Array = one + 0.5 * (a - b) + scale * random.standard_normal(one.size)
    return np.asarray(np.clip(moved, 0.0, 1.0))


def held_out(
    problem: Problem, fits: Sequence[Evaluation], pool: Pool, done: Callable[[list[Predicted]], None]
) -> list[RowSpread]:
    """Each of JUDGED under every fit. Called only once the fits are chosen."""
    calls = [(JUDGED, problem.space.decode(fit.z), problem.seed) for fit in fits]
    numbers = np.array([[number for number, _ in ours] for ours in pool.map(predict, calls, done)])
    return [row_spread(row, column) for row, column in zip(JUDGED, numbers.T, strict=True)]


def row_spread(row: PaperRow, numbers: Array) -> RowSpread:
    """Least, middle and largest of the numbers (fits,), the best fit's first."""
    there = numbers[np.isfinite(numbers)]
    low, median, high = np.percentile(there, (0, 50, 100)) if there.size else (np.nan,) * 3
    return RowSpread(row, float(numbers[0]), float(low), float(median), float(high), there.size)
