"""Paper, "Stability and Passivity Analysis", over random actuators and inputs: a body stores no more than it is given.

H(t) <= H(0) + work of the torques + work of the observer's forces (+ Baumgarte's, which the paper's proof omits). RK4
keeps it within (dt omega)^4 omega t of the energy that went through: its order, omega the fastest mode.
"""

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as some

from controller.arrays import Array
from controller.assembly.rod import build_rod
from controller.assembly.stability import natural_modes
from controller.kernels.model.energy import (
    BAUMGARTE,
    DAMPING,
    OBSERVER,
    PNEUMATIC,
    make_ledger,
    open_ledger,
    stored_energy,
)
from controller.kernels.model.rod import RodModel, make_load, make_work
from controller.kernels.model.statics import at_rest
from controller.schema.actuator import PRESETS, Actuator
from tests.controller.chains import booked_steps, thrown

pytestmark = pytest.mark.keyed()

STEP = 0.05
"""dt times the fastest mode or Baumgarte's."""
HOLD = 20
"""Steps for which an input is held."""


class Run(NamedTuple):
    """Energies along a run, a value for each step (n,) [J]."""

    stored: Array
    damped: Array
    supplied: Array
    """Torques, observer's forces and Baumgarte."""
    error: Array
    """Of the ledger."""
    bound: float
    """Of the integrator: its share of the most that was stored above rest and all that any power moved."""


actuators = some.builds(
    lambda mass, length, k, b, alpha, gravity, tip_load, curvature: Actuator(
        name="any",
        mass=mass,
        length=length,
        k=k,
        b=b,
        alpha=alpha,
        gravity=gravity,
        tip_load=tip_load,
        rest_curvature=(curvature,),
    ),
    mass=some.floats(0.05, 0.5),
    length=some.floats(0.1, 0.5),
    k=some.tuples(some.floats(0.02, 0.5), some.floats(0.02, 0.5)),
    b=some.tuples(some.floats(0.0, 1e-3), some.floats(0.0, 1e-3)),
    alpha=some.floats(0.0, 10.0),
    gravity=some.tuples(some.floats(0.0, 2.0), some.floats(-0.5, 0.5)),
    tip_load=some.floats(0.0, 0.2),
    curvature=some.floats(-5.0, 5.0),
)
rods = some.sampled_from([2, 3, 10])
seeds = some.integers(0, 2**32 - 1)


def driven(model: RodModel, seed: int, torque: float, force: float, spans: int = 30) -> Run:
    """From a random throw under inputs drawn again for each span: u up to `torque` [N m], forces up to `force` [N]."""
    random, count = np.random.default_rng(seed), model.L.size
    state, load, work, ledger = thrown(model, seed, 0.2, 1.0), make_load(count), make_work(count), make_ledger()
    dt = STEP / max(model.omega_B, float(np.abs(natural_modes(model, state.q[2])).max()))
    open_ledger(model, state, ledger)
    rows = np.zeros((spans * HOLD + 1, 6))
    rows[0, 0] = ledger.energy[0]
    for start in range(1, len(rows), HOLD):
        u, rod = random.uniform(-torque, torque, 2), random.integers(count)
        load.Q_theta[:], load.F[:] = model.T_theta @ u, 0.0
        load.F[:, rod] = random.uniform(-force, force, 2)
        booked_steps(model, state, load, dt, work, ledger, u, rows[start : start + HOLD])
    stored, error, powers = rows[:, 0], rows[:, 1], dt * rows[:, 2:]
    least = stored_energy(model, at_rest(model).q, np.zeros((3, count)))
    given = np.cumsum(powers, axis=0)
    throughput = float(stored.max() - least + np.abs(powers).sum())
    bound = STEP**4 * STEP * len(stored) * throughput
    return Run(stored, given[:, DAMPING], given[:, [PNEUMATIC, OBSERVER, BAUMGARTE]].sum(axis=1), error, bound)


@settings(max_examples=60, deadline=None)
@given(actuator=actuators, rods=rods, seed=seeds, torque=some.floats(0.0, 0.05), force=some.floats(0.0, 0.5))
def test_stored_energy_never_exceeds_what_was_supplied(
    actuator: Actuator, rods: int, seed: int, torque: float, force: float
) -> None:
    run = driven(build_rod(actuator, rods), seed, torque, force)
    assert (run.stored - run.stored[0] <= run.supplied + run.bound).all()
    assert (np.diff(run.damped) <= 0.0).all()
    assert np.abs(run.error).max() <= run.bound


@settings(max_examples=30, deadline=None)
@given(actuator=actuators, rods=rods, seed=seeds)
def test_energy_never_rises_when_nothing_is_supplied(actuator: Actuator, rods: int, seed: int) -> None:
    run = driven(build_rod(actuator, rods), seed, torque=0.0, force=0.0)
    assert np.diff(run.stored).max() <= run.bound


def test_the_bound_is_far_below_what_the_torques_supply() -> None:
    """So the first test would notice a term that is missing or has the wrong sign."""
    run = driven(build_rod(PRESETS["P1"], 10), 3, torque=0.05, force=0.0)
    assert np.abs(run.supplied).max() > 100 * run.bound
