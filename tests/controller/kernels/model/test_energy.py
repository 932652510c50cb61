"""The energy ledger: nothing comes from nowhere, and what is booked is what is there."""

import numpy as np
import pytest

from controller.arrays import Array
from controller.kernels.model.energy import BAUMGARTE, OBSERVER, PNEUMATIC, make_ledger, open_ledger, stored_energy
from controller.kernels.model.rod import Load, RodModel, RodState, make_load, make_work
from controller.kernels.model.statics import at_rest
from tests.controller.chains import NO_TORQUE, booked_steps, preset, thrown
from tests.oracles import Chain

pytestmark = pytest.mark.keyed()


def booked(model: RodModel, state: RodState, load: Load, u: Array, dt: float, count: int) -> tuple[Array, Array, Array]:
    """Stored energy and ledger after each step (n,), and the powers of the last one (4,)."""
    ledger, kept = make_ledger(), np.zeros((count, 6))
    open_ledger(model, state, ledger)
    booked_steps(model, state, load, dt, make_work(model.L.size), ledger, u, kept)
    return kept[:, 0], kept[:, 1], ledger.power


def pressed(model: RodModel, u: Array) -> Load:
    load = make_load(model.L.size)
    load.Q_theta[:] = model.T_theta @ u
    return load


@pytest.mark.parametrize("name", ["P1", "P2", "P3"])
@pytest.mark.parametrize("seed", range(8))
def test_energy_never_rises_without_force(name: str, seed: int) -> None:
    model = preset(name)
    state = thrown(model, seed)
    before = stored_energy(model, state.q, state.v)
    energy, _, _ = booked(model, state, make_load(10), NO_TORQUE, 2e-4, 25_000)
    assert np.diff([before, *energy]).max() <= 1e-9 * before
    assert energy[-1] < 0.1 * before


def test_stored_energy_is_the_papers_quadratic_form() -> None:
    model = preset("P2", g=np.array([1.0, -9.0]))
    state, chain = thrown(model, 4), Chain(model)
    q, v = state.q.T.ravel(), state.v.T.ravel()
    height = -model.m @ (model.g @ state.q[:2])
    expected = v @ chain.mass() @ v / 2 + q @ chain.stiffness() @ q / 2 + height
    assert stored_energy(model, state.q, state.v) == pytest.approx(expected, rel=1e-13)


def test_the_ledger_closes_at_the_order_of_the_integrator_under_every_kind_of_load() -> None:
    model, u = preset("P1", g=np.array([0.5, -1.0])), np.array([0.02, -0.01])
    load = pressed(model, u)
    load.F[:, 6], load.Q_theta[6] = (0.05, 0.1), load.Q_theta[6] + 0.002
    coarse, fine = (
        np.abs(booked(model, thrown(model, 1, 0.1, 0.5), load, u, dt, round(0.5 / dt))[1]).max() for dt in (1e-3, 5e-4)
    )
    assert 12.0 < coarse / fine < 20.0
    assert fine < 1e-6


def test_powers_are_those_of_the_papers_equation() -> None:
    model, u = preset("P2"), np.array([0.01, 0.02])
    load, chain, state = pressed(model, u), Chain(model), thrown(model, 5)
    load.F[:, 9] = 0.3, -0.2
    v = state.v.T.ravel()
    expected = [-v @ chain.damping() @ v, u @ model.T_theta.T @ state.v[2], load.F[:, 9] @ state.v[:2, 9], 0.0]
    power = booked(model, state, load, u, 1e-9, 1)[2]
    assert power == pytest.approx(expected, rel=1e-5, abs=1e-9)


def test_a_force_off_the_centre_works_on_the_velocity_of_its_own_point() -> None:
    model, state, load = preset("P1"), thrown(preset("P1"), 6), make_load(10)
    force, arm = np.array([0.2, -0.4]), model.L[3] / 2 * np.array([np.cos(state.q[2, 3]), np.sin(state.q[2, 3])])
    load.F[:, 3], load.Q_theta[3] = force, arm[0] * force[1] - arm[1] * force[0]
    joint = state.v[:2, 3] + state.v[2, 3] * np.array([-arm[1], arm[0]])
    assert booked(model, state, load, NO_TORQUE, 1e-9, 1)[2][OBSERVER] == pytest.approx(force @ joint, rel=1e-5)


def test_baumgartes_work_is_booked_when_it_closes_a_torn_chain() -> None:
    model = preset("P1")
    state = at_rest(model)
    state.q[1, 5:] += 1e-3
    energy, ledger, power = booked(model, state, make_load(10), NO_TORQUE, 2e-4, 100)
    assert energy.max() > 1e-6  # Baumgarte is a force of its own: it gives energy that the paper's proof omits
    assert abs(power[BAUMGARTE]) > 1e-6
    assert power[PNEUMATIC] == power[OBSERVER] == 0.0
    assert np.abs(ledger).max() < 1e-3 * energy.max()
