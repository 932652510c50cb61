"""How a step's time grows with the number of rods: RK4 and implicit, each beside a dense solver of its own system."""

from collections.abc import Callable
from typing import TypedDict

import numpy as np

from controller.assembly.rod import build_rod
from controller.assembly.stability import STEP_MARGIN, largest_step
from controller.errors import TendrilError
from controller.kernels.model.implicit import ImplicitWork, implicit_step, make_implicit_work
from controller.kernels.model.integrate import rk4_step
from controller.kernels.model.rod import Load, RodModel, RodState, Work, make_load, make_work
from controller.kernels.model.statics import at_rest, pose
from controller.realtime.compiled import compiled
from controller.research.bench.dense import dense_step, solve_dense_stages
from controller.research.bench.stopwatch import time_steps
from controller.schema.actuator import PRESETS
from controller.schema.parameters import DT

RODS = (10, 20, 50, 100, 300, 1000)
DENSE_MAX = 300
"""Largest chain that the dense solver is asked for: 0.4 s a step."""
RELEASED_AT = 0.015
"""The chain starts bent by u1 = u2 of this [N m] and is let go."""


class Scaling(TypedDict):
    """One chain length in `scaling`."""

    n: int
    integrator: str
    dt: float
    """Step used [s]: a stable one."""
    step_us: float
    dense_step_us: float | None


class Chain:
    """P1 with `rods` rods, let go from a bent pose, to be timed in turns with others."""

    def __init__(self, rods: int, integrator: str) -> None:
        self.rods, self.integrator = rods, integrator
        self.model = build_rod(PRESETS["P1"], rods)
        self.dt = DT if integrator == "implicit" else stable_step(self.model)
        self._state, self._load = bent(self.model, RELEASED_AT), make_load(rods)
        self._run = self._stepper()
        self._times: list[float] = []

    def _stepper(self) -> Callable[[int], None]:
        model, state, load, dt = self.model, self._state, self._load, self.dt
        if self.integrator == "implicit":
            implicit_work = make_implicit_work(self.rods)
            return lambda count: run_implicit_steps(model, state, load, dt, implicit_work, count)
        work = make_work(self.rods)
        return lambda count: run_steps(model, state, load, dt, work, count)

    def time(self) -> None:
        """Time it once more, for about 1 ms."""
        self._times.append(time_steps(self._run, max(1, 15_000 // self.rods)))

    def row(self) -> Scaling:
        """Its median time and the dense solver's. Raises TendrilError where the state has left the finite numbers."""
        if not (np.isfinite(self._state.q).all() and np.isfinite(self._state.v).all()):
            raise TendrilError(f"the chain of {self.rods} rods left the finite numbers at dt = {self.dt:.1e} s")
        step_us = float(np.median(self._times))
        return Scaling(
            n=self.rods, integrator=self.integrator, dt=self.dt, step_us=step_us, dense_step_us=self._dense()
        )

    def _dense(self) -> float | None:
        if self.rods > DENSE_MAX:
            return None
        model, state, load, dt = self.model, bent(self.model, RELEASED_AT), self._load, self.dt
        repeats = max(1, 300 // self.rods)
        if self.integrator == "implicit":
            return time_steps(lambda count: solve_dense_stages(model, state.q, dt, count), repeats)
        work = make_work(self.rods)
        return time_steps(lambda count: run_dense_steps(model, state, load, dt, work, count), repeats)


@compiled
def run_steps(model: RodModel, state: RodState, load: Load, dt: float, work: Work, count: int) -> None:
    """`count` RK4 steps of dt [s]."""
    for _ in range(count):
        rk4_step(model, load, dt, state, work)


@compiled
def run_implicit_steps(model: RodModel, state: RodState, load: Load, dt: float, work: ImplicitWork, count: int) -> None:
    """`count` implicit steps of dt [s]."""
    for _ in range(count):
        implicit_step(model, load, dt, state, work)


@compiled
def run_dense_steps(model: RodModel, state: RodState, load: Load, dt: float, work: Work, count: int) -> None:
    """`count` RK4 steps of dt [s] with the dense solver."""
    for _ in range(count):
        dense_step(model, state, load, dt, work)


def time_chains(rounds: int, rods: tuple[int, ...] = RODS) -> list[Scaling]:
    """A row for each integrator and number of rods; chains are timed in turns, so all see the same disturbances."""
    chains = [Chain(n, integrator) for integrator in ("RK4", "implicit") for n in rods]
    for _ in range(rounds):
        for chain in chains:
            chain.time()
    return [chain.row() for chain in chains]


def step_us(rows: list[Scaling], integrator: str, rods: int) -> float:
    """Median time [us] of a step in `rows`."""
    return next(row["step_us"] for row in rows if (row["integrator"], row["n"]) == (integrator, rods))


def stable_step(model: RodModel) -> float:
    """A step [s] for which RK4 is stable with a margin."""
    return min(DT, STEP_MARGIN * largest_step(model))


def bent(model: RodModel, u: float) -> RodState:
    """At rest in the static pose of u1 = u2 = u [N m]."""
    state = at_rest(model)
    pose(model, model.rest + model.compliance @ (u, u), state.q)
    return state
