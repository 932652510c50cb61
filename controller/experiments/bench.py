"""`tendril bench` without the live loop: rod step beside MuJoCo, controller tick, and how the step scales with N."""

import time
from collections.abc import Callable
from typing import TypedDict

import numpy as np

from controller.actuator import PRESETS
from controller.build import build_rod
from controller.errors import TendrilError
from controller.experiments.dense import dense_step
from controller.experiments.mujoco_chain import MujocoChain
from controller.experiments.tick_bench import tick_us
from controller.kernels.integrate import rk4_step
from controller.kernels.rod import Load, RodModel, RodState, Work, make_load, make_work
from controller.kernels.statics import at_rest, pose, tip_of
from controller.realtime.compiled import compiled
from controller.stability import STEP_MARGIN, largest_step

DT = 1e-3
TORQUE = 0.02
"""Step of torque on the last rod [N m]."""
CHAIN_SECONDS = 2.0
SCALING = (10, 20, 50, 100, 300, 1000)
DENSE_MAX = 300
"""Largest chain that the dense solver is asked for: 0.4 s a step."""
EIGENVALUES_MAX = 100
"""Largest chain whose stable step is computed; beyond, it falls with N^4 (the hinges' dampers on the rods' inertia)."""


class Scaling(TypedDict):
    """One chain length in `scaling`."""

    n: int
    integrator: str
    dt: float
    """Stable step used [s]."""
    step_us: float
    dense_step_us: float | None


class Figures(TypedDict):
    """What `bench` measures; times are medians [us]."""

    rod_step_us: float
    mujoco_step_us: float
    mujoco_tip_difference_m: float
    tick_us: float
    scaling: list[Scaling]


def bench(quick: bool = False) -> Figures:
    """All figures but the live loop's. Raises TendrilError without mujoco, or when a state is not finite."""
    rounds = 31 if quick else 201
    rod, mujoco = time_beside_mujoco(rounds)
    return Figures(
        rod_step_us=rod,
        mujoco_step_us=mujoco,
        mujoco_tip_difference_m=mujoco_tip_difference(),
        tick_us=tick_us(2_000 if quick else 20_000),
        scaling=[time_chain(rods, rounds) for rods in SCALING],
    )


@compiled
def run_steps(model: RodModel, state: RodState, load: Load, dt: float, work: Work, count: int) -> None:
    """`count` RK4 steps of dt [s]."""
    for _ in range(count):
        rk4_step(model, state, load, dt, work)


@compiled
def run_dense_steps(model: RodModel, state: RodState, load: Load, dt: float, work: Work, count: int) -> None:
    """`count` RK4 steps of dt [s] with the dense solver."""
    for _ in range(count):
        dense_step(model, state, load, dt, work)


def hinge_chain() -> tuple[RodModel, Load]:
    """P1 with 10 rods, without mass damping (MuJoCo's hinges have none), and the torque on its last rod."""
    model = build_rod(PRESETS["P1"], 10)._replace(alpha=0.0)
    load = make_load(10)
    load.Q_theta[-1] = TORQUE
    return model, load


def mujoco_tip_difference() -> float:
    """Largest distance between our tip and MuJoCo's [m] over 2 s after the step of torque."""
    model, load = hinge_chain()
    state, work, chain = at_rest(model), make_work(10), MujocoChain(model, DT)
    chain.load(load.Q_theta)
    worst = 0.0
    for _ in range(round(CHAIN_SECONDS / DT)):
        run_steps(model, state, load, DT, work, 1)
        chain.step()
        worst = max(worst, float(np.linalg.norm(chain.tip() - tip_of(model, state.q))))
    return worst


def time_beside_mujoco(rounds: int) -> tuple[float, float]:
    """Time of one step of ours and of MuJoCo's [us], measured in turns: both see the same disturbances."""
    model, load = hinge_chain()
    state, work, chain = at_rest(model), make_work(10), MujocoChain(model, DT)
    chain.load(load.Q_theta)
    ours, theirs = [], []
    for _ in range(rounds):
        ours.append(time_steps(lambda count: run_steps(model, state, load, DT, work, count), 1000))
        theirs.append(time_steps(chain.step, 200))
    return float(np.median(ours)), float(np.median(theirs))


def time_steps(run: Callable[[int], None], count: int) -> float:
    """Time of one of `count` steps that `run(count)` makes [us]; one is made before the clock starts.

    About 2 ms in all: shorter than another program's turn on the core, so that most rounds are undisturbed.
    """
    run(1)
    start = time.perf_counter()
    run(count)
    return (time.perf_counter() - start) / count * 1e6


def time_chain(rods: int, rounds: int) -> Scaling:
    """Times of one RK4 step of P1 with `rods` rods, let go from a bent pose, ours and with the dense solver."""
    model = build_rod(PRESETS["P1"], rods)
    dt, load, work = stable_step(model), make_load(rods), make_work(rods)
    state, dense_state = bent(model, 0.015), bent(model, 0.015)
    count = max(1, 15_000 // rods)
    times = [time_steps(lambda n: run_steps(model, state, load, dt, work, n), count) for _ in range(rounds)]
    dense = None
    if rods <= DENSE_MAX:
        repeats = max(1, 300 // rods)
        dense = time_steps(lambda n: run_dense_steps(model, dense_state, load, dt, work, n), repeats)
    if not (np.isfinite(state.q).all() and np.isfinite(state.v).all() and np.isfinite(dense_state.q).all()):
        raise TendrilError(f"the chain of {rods} rods left the finite numbers at dt = {dt:.1e} s")
    return Scaling(n=rods, integrator="RK4", dt=dt, step_us=float(np.median(times)), dense_step_us=dense)


def stable_step(model: RodModel) -> float:
    """A step [s] for which RK4 is stable with a margin."""
    rods = model.L.size
    known = model if rods <= EIGENVALUES_MAX else build_rod(PRESETS["P1"], EIGENVALUES_MAX)
    return min(DT, STEP_MARGIN * largest_step(known) * (known.L.size / rods) ** 4)


def bent(model: RodModel, u: float) -> RodState:
    """At rest in the static pose of u1 = u2 = u [N m]."""
    state = at_rest(model)
    pose(model, model.rest + model.compliance @ (u, u), state.q)
    return state
