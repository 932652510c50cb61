"""The search: a screening of the whole box, then the best points polished by bounded least squares.

The Jacobian's columns are evaluated side by side and one start after the other is polished, the best first: with a
budget of time the first fit is then a finished one, and the parent process knows every point that was evaluated.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares

from controller.arrays import Array
from controller.research.calibration.problem import HOPELESS, Evaluation, Problem, evaluate, keeps_margins
from controller.research.experiments.pool import OutOfTime, Pool, WorkerDied

STEP_SHARE = 0.03
"""Of the finite differences, as a share of the box: friction makes the cost rough below."""
TOLERANCE = 3e-3
"""Relative change of cost or point at which a start counts as polished."""
APART = 0.15
"""Starts are no nearer to one another than this, rms over the coordinates of the cube."""


class Stage(NamedTuple):
    """A part of the search."""

    name: str
    most: int
    """Evaluations, at most."""


Report = Callable[[Stage, float], None]
"""Told of each evaluation: its stage, and the best cost so far (inf: none yet)."""


@dataclass(frozen=True)
class Effort:
    """How much is spent."""

    screen: int = 100
    """Points of the screening."""
    starts: int = 2
    steps: int = 8
    """Points of each polish at most, with a Jacobian at every one that is better."""
    generations: int = 60
    """Of the evolution that follows."""
    rounds: int = 40
    """Moves of every near-equal fit."""
    minutes: float = 30.0
    """Budget of screening, polish and evolution; the near-equal fits get as much on top. A search that it cuts short
    depends on the speed of the machine; one that finishes does not."""


QUICK = Effort(screen=8, starts=1, steps=2, generations=0, rounds=1, minutes=1.0)
"""Whether it runs."""


def effort_of(base: Effort, **given: float | None) -> Effort:
    """`base` with those of its fields that are given and not None."""
    changed: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    return replace(base, **changed)


@dataclass
class Search:
    """Every point that was evaluated, and when to stop."""

    problem: Problem
    pool: Pool
    effort: Effort
    report: Report = lambda stage, best: None
    found: list[Evaluation] = field(default_factory=list)
    _until: float = field(init=False)

    def __post_init__(self) -> None:
        self._until = time.monotonic() + 60.0 * self.effort.minutes

    def run(self, seed: int) -> None:
        """Screen and polish. Raises OutOfTime when the budget is spent."""
        for number, start in enumerate(self.screen(seed), 1):
            self.polish(start, f"start {number}")

    def screen(self, seed: int) -> list[Evaluation]:
        """The best of points spread as the priors are, apart from one another."""
        points = self.problem.space.draw(self.effort.screen, seed)
        screened = self.evaluate(points, Stage("screening", len(points)), HOPELESS)
        return apart(ranked(screened), self.effort.starts, APART)

    def polish(self, start: Evaluation, name: str) -> None:
        """Bounded least squares from `start`; everything it evaluates is kept."""
        seen = {start.z.tobytes(): start.residuals} if start.margins else {}
        stage = Stage(name, self.effort.steps * (start.z.size + 1))

        def residuals(z: Array) -> Array:
            if z.tobytes() not in seen:
                seen[z.tobytes()] = self.evaluate([z], stage)[0].residuals
            return seen[z.tobytes()]

        def jacobian(z: Array) -> Array:
            points, steps = neighbours(z)
            moved = np.array([one.residuals for one in self.evaluate(points, stage)])
            return np.asarray((moved - residuals(z)).T / steps)

        least_squares(
            residuals,
            start.z,
            jacobian,
            bounds=(0.0, 1.0),
            ftol=TOLERANCE,
            xtol=TOLERANCE,
            gtol=None,
            max_nfev=self.effort.steps,
        )

    def evaluate(
        self, points: Sequence[Array] | Array, stage: Stage, hopeless: float | Sequence[float] = np.inf
    ) -> list[Evaluation]:
        """All points side by side, `hopeless` for all or one each. Raises OutOfTime when the budget is spent."""

        def note(one: Evaluation) -> None:
            self.found.append(one)
            self.report(stage, self.best_cost)

        if time.monotonic() > self._until:
            raise OutOfTime
        limits = [hopeless] * len(points) if isinstance(hopeless, float) else hopeless
        calls = [(self.problem, z, limit) for z, limit in zip(points, limits, strict=True)]
        return self.pool.map(evaluate, calls, note, lambda: time.monotonic() > self._until)

    def allow(self, minutes: float) -> None:
        """Give more time from now on."""
        self._until = time.monotonic() + 60.0 * minutes

    @property
    def best_cost(self) -> float:
        """Cost of the best point that keeps the margins; inf without one."""
        best = self.best()
        return best.cost if best else np.inf

    def best(self) -> Evaluation | None:
        """The point of least cost that keeps the margins, of all that were evaluated: by cost alone."""
        kept = [one for one in self.found if keeps_margins(self.problem, one)]
        return min(kept, key=lambda one: (one.cost, one.z.tobytes()), default=None)


def ending(work: Callable[[], None]) -> str:
    """How `work` ended: "finished", or what cut it short. Nothing that a search has found is lost by it."""
    try:
        work()
    except OutOfTime:
        return "out of time"
    except KeyboardInterrupt:
        return "interrupted"
    except WorkerDied:
        return "a worker died"
    return "finished"


def neighbours(z: Array) -> tuple[Array, Array]:
    """Points (n,n) one STEP_SHARE away from z (n,) along each coordinate, into the box, and the signed steps (n,)."""
    steps = np.where(z + STEP_SHARE <= 1.0, STEP_SHARE, -STEP_SHARE)
    return z + np.diag(steps), steps


def distance(a: Evaluation, b: Evaluation) -> float:
    """Between two points of the cube, rms over its coordinates."""
    return float(np.sqrt(np.mean((a.z - b.z) ** 2)))


def ranked(found: Sequence[Evaluation]) -> list[Evaluation]:
    """The best first; points that were not asked for their margins last."""
    return sorted(found, key=lambda one: (not one.margins, one.cost, one.z.tobytes()))


def apart(ordered: Sequence[Evaluation], count: int, least: float) -> list[Evaluation]:
    """At most `count`, in order, none nearer than `least` to one before it."""
    chosen: list[Evaluation] = []
    for one in ordered:
        if len(chosen) < count and all(distance(one, other) >= least for other in chosen):
            chosen.append(one)
    return chosen
