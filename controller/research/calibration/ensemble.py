"""The fits that are as good as the best, drawn as what the rows, priors and margins leave open spreads them.

Differential evolution as a Markov chain (ter Braak 2006): every walker tries a step along the difference of two others
and takes it with probability exp(-what it costs more), so that in the end walkers lie as exp(-cost) does. One half of
them moves at a time, by differences within the other half, so that a half can be evaluated side by side.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from controller.arrays import Array
from controller.research.calibration.problem import Evaluation, keeps_margins
from controller.research.calibration.search import Search, Stage, neighbours

WALKERS, FITS_MIN = 24, 20
"""Near-equal fits, and below how many of them an interval says little."""
BELIEVED = 18.0
"""A drawn fit may cost this much more than the best; 9 is the mean of 18 unknowns, and one in twenty is beyond 14."""
ATTEMPTS = 6
"""How often fits are drawn, each time nearer to the best, until there are enough walkers."""
NEARER = 0.7
"""By how much nearer."""
JITTER = 1e-3
"""What is added to every step, so that no direction is left out."""
LEAP = 10
"""In one of this many rounds a step is the whole difference: from one valley to another."""


@dataclass
class Ensemble:
    """Walkers and how they fared."""

    walkers: list[Evaluation] = field(default_factory=list)
    rounds: int = 0
    tried: int = 0
    accepted: int = 0

    def fits(self, best: Evaluation) -> list[Evaluation]:
        """`best` first, then the walkers by cost; none twice."""
        others = sorted(self.walkers, key=lambda one: (one.cost, one.z.tobytes()))
        return list({one.z.tobytes(): one for one in (best, *others)}.values())


def gather(search: Search, ensemble: Ensemble, seed: int) -> None:
    """Put the walkers where a normal distribution about the best fit has them: that of its own Jacobian.

    It is what exp(-cost) would be if residuals were linear; the walk corrects it. Raises OutOfTime when the budget is
    spent.
    """
    best = search.best()
    if best is None:
        return
    random, spread = np.random.default_rng([seed, 1]), root_of_covariance(search, best)
    ensemble.walkers = [best]
    for attempt in range(ATTEMPTS):
        far = NEARER**attempt
        points = [reflected(best.z + far * spread @ random.standard_normal(best.z.size)) for _ in range(WALKERS)]
        tried = search.evaluate(points, Stage("first walkers", ATTEMPTS * WALKERS), best.cost + BELIEVED)
        good = [one for one in tried if one.cost <= best.cost + BELIEVED and keeps_margins(search.problem, one)]
        ensemble.walkers = [*ensemble.walkers, *good][:WALKERS]
        if len(ensemble.walkers) == WALKERS:
            return


def root_of_covariance(search: Search, best: Evaluation) -> Array:
    """R (n,n) with R R^T = (J^T J)^-1, J the slopes of the residuals of rows and priors at the best fit.

    Priors are among the residuals, so that J^T J has an inverse.
    """
    points, steps = neighbours(best.z)
    tried = search.evaluate(points, Stage("slopes", len(points)), -np.inf)
    count = min(one.residuals.size for one in tried)
    J = (np.array([one.residuals[:count] for one in tried]) - best.residuals[:count]).T / steps
    return np.asarray(np.linalg.inv(np.linalg.cholesky(J.T @ J)).T)


def walk(search: Search, ensemble: Ensemble, seed: int) -> None:
    """Let the walkers move. Raises OutOfTime when the budget is spent; they then stand where they were."""
    gather(search, ensemble, seed)
    random, count = np.random.default_rng([seed, 2]), len(ensemble.walkers)
    if count < 4:
        return
    stage = Stage("near-equal fits", search.effort.rounds * count)
    for number in range(search.effort.rounds):
        for half in (range(count // 2), range(count // 2, count)):
            move(search, ensemble, half, number, random, stage)
        ensemble.rounds += 1


def move(
    search: Search, ensemble: Ensemble, half: range, number: int, random: np.random.Generator, stage: Stage
) -> None:
    """One step of the walkers `half`, along differences within the other half."""
    walkers = ensemble.walkers
    others = [walkers[i].z for i in range(len(walkers)) if i not in half]
    points = [reflected(walkers[i].z + stride(others, number, random)) for i in half]
    bounds = [walkers[i].cost - math.log(random.uniform(1e-300, 1.0)) for i in half]
    tried = search.evaluate(points, stage, bounds)
    for i, one, bound in zip(half, tried, bounds, strict=True):
        ensemble.tried += 1
        if one.cost <= bound and keeps_margins(search.problem, one):
            walkers[i] = one
            ensemble.accepted += 1


def stride(others: Sequence[Array], number: int, random: np.random.Generator) -> Array:
    """A step (n,): a share of the difference of two of `others`, and a little in every direction."""
    a, b = random.choice(len(others), 2, replace=False)
    size = others[a].size
    share = 1.0 if number % LEAP == LEAP - 1 else 2.38 / math.sqrt(2.0 * size)
    return np.asarray(share * (others[a] - others[b]) + JITTER * random.standard_normal(size))


def reflected(z: Array) -> Array:
    """z (n,) thrown back into the cube at its walls: a step and the one back stay equally likely."""
    return np.asarray(np.abs((z + 1.0) % 2.0 - 1.0))
