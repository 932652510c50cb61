"""RK4 and the implicit step: what their docstrings state of order, stability, energy and constraints."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as some

from controller.arrays import Array
from controller.assembly.rod import build_rod
from controller.kernels.model.energy import BAUMGARTE, Ledger, make_ledger, open_ledger, stored_energy
from controller.kernels.model.implicit import (
    ImplicitWork,
    book_implicit_step,
    implicit_step,
    make_implicit_work,
    meet_hinges,
)
from controller.kernels.model.rod import Load, RodModel, RodState, make_load, make_work
from controller.kernels.model.statics import at_rest, tip_of
from controller.schema.actuator import PRESETS
from tests.controller.chains import NO_TORQUE, booked_steps, compiled, posed, preset, sprung, steps, thrown
from tests.oracles import Chain

pytestmark = pytest.mark.keyed()


@compiled
def implicit_steps(
    model: RodModel, state: RodState, load: Load, dt: float, work: ImplicitWork, ledger: Ledger, u: Array, kept: Array
) -> None:
    """One step for each row of `kept` (n,6): stored energy, ledger [J] and the four powers [W]."""
    for i in range(kept.shape[0]):
        implicit_step(model, load, dt, state, work)
        kept[i, 1] = book_implicit_step(model, state, load, u, dt, work, ledger)
        kept[i, 0] = ledger.energy[0]
        kept[i, 2:] = ledger.power


def implicit(model: RodModel, state: RodState, load: Load, seconds: float, dt: float, u: Array = NO_TORQUE) -> Array:
    """Energy, ledger and powers after each step (n,6); `state` moves on."""
    kept, ledger = np.zeros((round(seconds / dt), 6)), make_ledger()
    open_ledger(model, state, ledger)
    work = make_implicit_work(model.L.size, load.springs.rod.size)
    implicit_steps(model, state, load, dt, work, ledger, u, kept)
    return kept


def explicit(model: RodModel, state: RodState, load: Load, seconds: float, dt: float) -> None:
    steps(model, state, load, dt, make_work(model.L.size), round(seconds / dt))


def pressed(model: RodModel, u: Array, load: Load | None = None) -> Load:
    load = load or make_load(model.L.size)
    load.Q_theta[:] = model.T_theta @ u
    return load


def pushed(model: RodModel) -> Load:
    """Torques, a force at the centre of a rod, and springs of the observer, two of them at one rod."""
    load = pressed(model, np.array([0.03, -0.02]), sprung(model, 5, 100.0, 0.5))
    load.springs.rod[1] = load.springs.rod[2]
    load.F[:, 6] = 0.05, 0.1
    return load


def ends(run: Any, model: RodModel, dts: list[float]) -> list[Array]:
    """Pose and velocity (6,N) after 0.3 s of a throw, for each dt."""
    found = []
    for dt in dts:
        state = thrown(model, 1, 0.1, 0.5)
        run(model, state, pushed(model), 0.3, dt)
        if run is implicit:
            meet_hinges(model, state.q, state.v, make_implicit_work(model.L.size))
        found.append(np.concatenate([state.q, state.v]))
    return found


@pytest.mark.parametrize(("run", "order", "dt"), [(explicit, 4.0, 5e-4), (implicit, 2.0, 5e-4)])
@pytest.mark.parametrize("name", ["P1", "P3"])
def test_pose_and_velocity_converge_at_the_stated_order(run: Any, order: float, dt: float, name: str) -> None:
    model = preset(name, g=np.array([0.5, -1.0]))
    (exact,) = ends(explicit, model, [2.5e-5])
    errors = [np.abs(end - exact).max(axis=1) for end in ends(run, model, [dt, dt / 2])]
    slopes = np.log2(errors[0] / errors[1])
    assert slopes == pytest.approx(np.full(6, order), abs=0.35)


@pytest.mark.parametrize("rods", [2, 10, 20])
def test_at_1_ms_both_move_the_tip_alike_after_a_step_of_torque(rods: int) -> None:
    model, fine, coarse = preset("P1", rods), at_rest(preset("P1", rods)), at_rest(preset("P1", rods))
    load = pressed(model, np.array([0.03, 0.0]))
    for _ in range(20):
        explicit(model, fine, load, 0.05, 1e-4)
        implicit(model, coarse, load, 0.05, 1e-3)
        assert np.linalg.norm(np.subtract(tip_of(model, fine.q), tip_of(model, coarse.q))) < 1e-4


@pytest.mark.parametrize("name", ["P1", "P2", "P3"])
@pytest.mark.parametrize(("rods", "stiffer", "tougher"), [(10, 100.0, 100.0), (300, 1.0, 100.0), (1000, 1.0, 1.0)])
def test_the_implicit_step_takes_1_ms_at_any_resolution_stiffness_and_damping(
    name: str, rods: int, stiffer: float, tougher: float
) -> None:
    model = preset(name, rods)
    model = model._replace(k=stiffer * model.k, b=tougher * model.b, alpha=20.0)
    u = np.full(2, 0.06)
    state, load = posed(model, model.compliance @ u / stiffer, np.zeros(rods)), pressed(model, -u)
    kept = implicit(model, state, load, 2.0, 1e-3, -u)
    assert np.diff(kept[:, 1]).max() < 1e-14
    free = make_load(rods)
    assert (np.diff(implicit(model, state, free, 2.0, 1e-3)[:, 0]) < 0.0).all()


@settings(max_examples=40, deadline=None)
@given(
    name=some.sampled_from(sorted(PRESETS)),
    rods=some.sampled_from([2, 3, 10, 40]),
    seed=some.integers(0, 2**32 - 1),
    dt=some.floats(1e-4, 2e-2),
    stiffer=some.floats(0.0, 100.0),
    tougher=some.floats(0.0, 100.0),
    pull=some.floats(0.0, 10.0),
    tip_load=some.floats(0.0, 0.5),
    K_o=some.floats(0.0, 1e5),
    B_o=some.floats(0.0, 1e3),
)
def test_the_implicit_step_never_stores_more_than_it_was_given(
    name: str,
    rods: int,
    seed: int,
    dt: float,
    stiffer: float,
    tougher: float,
    pull: float,
    tip_load: float,
    K_o: float,
    B_o: float,
) -> None:
    """For any step, input and motion: its docstring's identity, which holds to rounding."""
    random = np.random.default_rng(seed)
    model = build_rod(PRESETS[name].model_copy(update={"tip_load": tip_load}), rods)
    model = model._replace(k=stiffer * model.k, b=tougher * model.b, g=pull * random.normal(size=2))
    state, u = thrown(model, seed, 0.3, 3.0), random.uniform(-0.06, 0.06, 2)
    load = pressed(model, u, sprung(model, seed, K_o, B_o))
    load.F[:, random.integers(rods)] = random.normal(size=2)
    before = stored_energy(model, state.q, state.v)
    kept = implicit(model, state, load, 60 * dt, dt, u)
    through = np.abs(kept[:, 0]).max() + abs(before) + np.abs(dt * kept[:, 2:]).sum()
    assert np.diff(kept[:, 1], prepend=0.0).max() <= 1e-12 * through


def test_damping_of_the_step_falls_with_its_square_and_baumgartes_power_is_gravitys() -> None:
    model, u = preset("P1", g=np.array([0.5, -1.0])), np.array([0.03, -0.02])
    coarse, fine = (implicit(model, thrown(model, 1, 0.1, 0.5), pressed(model, u), 0.3, dt, u) for dt in (5e-4, 2.5e-4))
    assert 3.4 < coarse[-1, 1] / fine[-1, 1] < 4.6
    level = implicit(model._replace(g=np.zeros(2)), thrown(model, 1), pressed(model, u), 0.3, 5e-4, u)
    assert (level[:, 2 + BAUMGARTE] == 0.0).all()
    assert 0.0 < np.abs(coarse[:, 2 + BAUMGARTE]).max() < 0.1 * np.abs(coarse[:, 2:]).max()


def test_rk4_loses_energy_to_the_fifth_order_of_the_step_when_nothing_damps() -> None:
    model = preset("P1", b=np.zeros(10), alpha=0.0)
    lost = []
    for dt in (5e-4, 2.5e-4):
        state, ledger, kept = thrown(model, 1, 0.1, 0.2), make_ledger(), np.zeros((round(1.0 / dt), 6))
        before = stored_energy(model, state.q, state.v)
        booked_steps(model, state, make_load(10), dt, make_work(10), ledger, NO_TORQUE, kept)
        lost.append(before - kept[-1, 0])
    assert lost[0] > lost[1] > 0.0
    assert 24.0 < lost[0] / lost[1] < 40.0


def test_hinges_stay_closed_over_100_s_of_motion() -> None:
    model, load = preset("P1"), make_load(10)
    closed, drifting = at_rest(model), at_rest(model)
    for second in np.arange(0.0, 100.0, 1.0):
        load.Q_theta[4], load.Q_theta[-1] = 0.02 * np.sin(7 * second), 0.02 * np.cos(5 * second)
        load.F[:, -1] = np.sin(3 * second), np.cos(2 * second)
        implicit(model, closed, load, 1.0, 1e-3)
        explicit(model, drifting, load, 1.0, 1e-3)
    gap, gap_rk4 = (np.abs(Chain(model).phi(state.q.T.ravel())).max() for state in (closed, drifting))
    assert gap < 1e-15
    assert gap_rk4 < 1e-6


@pytest.mark.parametrize("run", [explicit, implicit])
@pytest.mark.parametrize("bend", [1e-70, 1e-300])
def test_motion_that_dies_out_never_becomes_denormal(run: Any, bend: float) -> None:
    model = preset("P1")
    state = posed(model, np.full(10, bend), np.zeros(10))
    run(model, state, make_load(10), 5.0, 1e-3)
    left = np.abs(np.concatenate([state.q[2], state.v.ravel()]))
    assert ((left == 0.0) | (left > 1e-200)).all()
