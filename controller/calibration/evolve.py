"""Differential evolution from the best points of a search.

Friction makes the cost rough and a margin is a wall: least squares alone ends there, a population finds its way on.
"""

from collections.abc import Iterable

import numpy as np
from scipy.optimize import Bounds, differential_evolution

from controller.calibration.problem import HOPELESS, Evaluation, Problem
from controller.calibration.search import Search, Stage, apart, ranked
from controller.kernels.rod import Array

MEMBERS = 24
"""Points of a generation."""
APART, SCATTER = 0.02, 0.08
"""Half of the first generation are points found, so far apart; the rest is strewn around them so widely. Both are rms
over the coordinates of the cube."""
MUTATION, RECOMBINATION = (0.4, 0.9), 0.7
BROKEN_MARGIN = 5.0
"""What each margin that is not kept adds to the cost: only a point that keeps them all can be chosen."""


def evolve(search: Search, seed: int) -> None:
    """Evaluate the generations of the search's effort; it keeps every point. Raises OutOfTime as it does."""
    generations = search.effort.generations
    if generations < 1:
        return
    random = np.random.default_rng(seed)
    stage = Stage("evolution", MEMBERS * (generations + 1))

    def costs(one: object, points: Iterable[Array]) -> list[float]:
        return [guarded(search.problem, found) for found in search.evaluate(list(points), stage)]

    def cost(z: Array, /) -> float:
        return costs(None, [z])[0]

    differential_evolution(
        cost,
        Bounds(*np.outer((0.0, 1.0), np.ones(search.found[0].z.size))),
        init=population(search.found, random),
        maxiter=generations,
        mutation=MUTATION,
        recombination=RECOMBINATION,
        polish=False,
        updating="deferred",
        workers=costs,
        rng=random,
    )


def guarded(problem: Problem, one: Evaluation) -> float:
    """Cost of a point for the evolution."""
    if len(one.margins) < len(problem.trials):
        return HOPELESS
    return one.cost + BROKEN_MARGIN * sum(not margin.kept for margin in one.margins)


def population(found: list[Evaluation], random: np.random.Generator) -> Array:
    """The best points (MEMBERS, n), filled up with points around them."""
    best = [one.z for one in apart(ranked(found), MEMBERS // 2, APART)]
    around = [best[random.integers(len(best))] for _ in range(MEMBERS - len(best))]
    strewn = [np.clip(z + SCATTER * random.standard_normal(z.size), 0.0, 1.0) for z in around]
    return np.array(best + strewn)
