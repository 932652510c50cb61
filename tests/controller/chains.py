"""Rod chains in known states, and their motion over many steps."""

from typing import Any

import numpy as np
from numba import njit

from controller.arrays import Array
from controller.assembly.rod import build_rod
from controller.assembly.statics import build_statics
from controller.kernels.model.energy import Ledger, ledger_step
from controller.kernels.model.integrate import rk4_step
from controller.kernels.model.rod import Load, RodModel, RodState, Work, make_load, make_work
from controller.kernels.model.statics import Statics, at_rest, places, points_on
from controller.schema.actuator import PRESETS

compiled: Any = njit(nogil=True, error_model="numpy")
NO_TORQUE = np.zeros(2)


def preset(name: str = "P1", rods: int = 10, **changes: Any) -> RodModel:
    return build_rod(PRESETS[name], rods)._replace(**changes)


def static(model: RodModel) -> Statics:
    """Its static map for torques up to those of the presets."""
    return build_statics(model, PRESETS["P1"].u_max)


def posed(model: RodModel, theta: Array, omega: Array) -> RodState:
    """The state with these angles and rates that meets every constraint."""
    state = RodState(np.zeros((3, theta.size)), np.zeros((3, theta.size)))
    along = np.array([np.cos(theta), np.sin(theta)])
    rate = omega * np.array([-np.sin(theta), np.cos(theta)])
    before = model.L - model.arm
    state.q[:2], state.q[2] = np.cumsum(model.L * along, axis=1) - before * along, theta
    state.v[:2], state.v[2] = np.cumsum(model.L * rate, axis=1) - before * rate, omega
    return state


def sprung(model: RodModel, seed: int, K: float, B: float, count: int = 3) -> Load:
    """A load of virtual springs and dampers between random points of the chain and moving places near it."""
    random, load = np.random.default_rng(seed), make_load(model.L.size, count)
    at = places(model, float(model.L.sum()) * np.sort(random.uniform(0.0, 1.0, count)))
    springs = load.springs
    springs.K[:], springs.B[:], springs.active[0] = (
        K * random.uniform(0.0, 1.0, 2),
        B * random.uniform(0.0, 1.0, 2),
        count,
    )
    springs.rod[:], springs.offset[:] = at.rod, at.offset
    points_on(at_rest(model).q, at, springs.anchor)
    springs.anchor[:] += 0.02 * random.normal(size=(count, 2))
    springs.rate[:] = 0.1 * random.normal(size=(count, 2))
    return load


def thrown(model: RodModel, seed: int, bend: float = 0.3, speed: float = 2.0) -> RodState:
    """A random state that meets every constraint: bent by about `bend` [rad] and turning by `speed` [rad/s] a joint."""
    random = np.random.default_rng(seed)
    turns = random.normal(size=(2, model.L.size))
    return posed(model, np.cumsum(bend * turns[0]), np.cumsum(speed * turns[1]))


@compiled
def steps(model: RodModel, state: RodState, load: Load, dt: float, work: Work, count: int) -> None:
    for _ in range(count):
        rk4_step(model, load, dt, state, work)


@compiled
def booked_steps(
    model: RodModel, state: RodState, load: Load, dt: float, work: Work, ledger: Ledger, u: Array, kept: Array
) -> None:
    """One step for each row of `kept` (n,6), which becomes stored energy, ledger [J] and the four powers [W]."""
    for i in range(kept.shape[0]):
        rk4_step(model, load, dt, state, work)
        kept[i, 1] = ledger_step(model, state, load, u, dt, work, ledger)
        kept[i, 0] = ledger.energy[0]
        kept[i, 2:] = ledger.power


def advance(model: RodModel, state: RodState, load: Load, seconds: float, dt: float = 1e-3) -> RodState:
    steps(model, state, load, dt, make_work(model.L.size), round(seconds / dt))
    return state


def assert_close(found: Array, expected: Array, relative: float) -> None:
    assert np.abs(found - expected).max() <= relative * np.abs(expected).max()
