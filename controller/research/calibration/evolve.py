"""CMA-ES from the best point of a search.

Friction makes the cost rough and a margin is a wall: least squares alone ends there, an evolution whose steps learn
the shape of the valley finds its way on.
"""

import cma
import numpy as np

from controller.arrays import Array
from controller.research.calibration.problem import Evaluation, Problem
from controller.research.calibration.search import Search, Stage, ranked

MEMBERS = 16
"""Points of a generation."""
SIGMA = 0.08
"""Standard deviation of the first generation along every coordinate of the cube."""
BROKEN_MARGIN = 5.0
"""What each margin that is not kept adds to the cost: only a point that keeps them all can be chosen."""
FAR = 25.0
"""A point whose rows and priors alone cost so much more than the best is not asked for its margins: half the work."""


def evolve(search: Search, seed: int) -> None:
    """Evaluate the generations of the search's effort; it keeps every point. Raises OutOfTime as it does."""
    if search.effort.generations < 1:
        return
    random = np.random.default_rng(seed)
    stage = Stage("evolution", MEMBERS * search.effort.generations)
    start = search.best() or ranked(search.found)[0]
    strategy = cma.CMAEvolutionStrategy(start.z, SIGMA, options(random))
    for _ in range(search.effort.generations):
        points = [np.clip(z, 0.0, 1.0) for z in strategy.ask()]
        found = search.evaluate(points, stage, search.best_cost + FAR)
        strategy.tell(points, [guarded(search.problem, one) for one in found])


def options(random: np.random.Generator) -> dict[str, object]:
    """The strategy's options: its only source of chance is `random`, and it prints and writes nothing."""

    def normal(count: int, size: int) -> Array:
        return random.standard_normal((count, size))

    return {
        "bounds": [0.0, 1.0],
        "popsize": MEMBERS,
        "randn": normal,
        "seed": np.nan,
        "verbose": -9,
    }


def guarded(problem: Problem, one: Evaluation) -> float:
    """Cost of a point for the evolution; margins that were not asked for count as broken."""
    unkept = len(problem.trials) - sum(margin.kept for margin in one.margins)
    return one.cost + BROKEN_MARGIN * unkept
