"""The rod chain against another engine, against the paper's dense matrix, and against what is known on paper."""

import math
from typing import Any

import numpy as np
import pytest
from numba import njit

from controller.arrays import Array
from controller.assembly.rod import build_rod
from controller.kernels.model.energy import Ledger, ledger_step, make_ledger
from controller.kernels.model.integrate import rk4_step
from controller.kernels.model.rod import RodModel, RodState, accelerate, make_load, make_work, sine_cosine
from controller.kernels.model.statics import at_rest, tip_of
from controller.research.bench.mujoco_chain import MujocoChain
from controller.schema.actuator import PRESETS
from tests.controller.chains import NO_TORQUE, advance, assert_close, posed, preset, thrown
from tests.oracles import Chain

pytestmark = pytest.mark.keyed()


@pytest.mark.parametrize(
    ("name", "gravity", "dt"), [("P1", (0.0, 0.0), 1e-3), ("P1", (1.0, -2.0), 1e-3), ("P3", (0.0, 0.0), 5e-4)]
)
def test_the_tip_follows_mujoco_within_a_micrometre_for_two_seconds(
    name: str, gravity: tuple[float, float], dt: float
) -> None:
    model = preset(name, alpha=0.0, g=np.array(gravity))
    state, load, chain = at_rest(model), make_load(10), MujocoChain(model, dt)
    load.Q_theta[-1] = 0.02
    chain.load(load.Q_theta)
    for _ in range(round(2.0 / dt)):
        advance(model, state, load, dt, dt)
        chain.step()
        assert np.linalg.norm(chain.tip() - tip_of(model, state.q)) < 1e-6


@pytest.mark.parametrize("rods", [2, 3, 10, 37])
@pytest.mark.parametrize("seed", range(5))
def test_accelerations_and_hinge_forces_solve_the_papers_dense_system(rods: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    arm = build_rod(PRESETS["P2"].model_copy(update={"tip_load": 0.1}), rods).arm
    model = preset("P2", rods, g=random.normal(size=2), arm=arm, bend=random.normal(size=rods))
    work, load = make_work(rods), make_load(rods)
    state = thrown(model, seed)
    work.q[0] = state.q + 1e-3 * random.normal(size=(3, rods))  # off the constraints: Baumgarte acts
    work.v[0] = state.v + 1e-2 * random.normal(size=(3, rods))
    load.F[:], load.Q_theta[:] = random.normal(size=(2, rods)), 0.05 * random.normal(size=rods)
    accelerate(model, load, 0, work)
    force = np.vstack([load.F, load.Q_theta]).T.ravel()
    acceleration, hinge = Chain(model).solve(work.q[0].T.ravel(), work.v[0].T.ravel(), force)
    assert_close(work.acc[0], acceleration.reshape(-1, 3).T, 1e-10)
    assert_close(work.lam[0][:, :rods], hinge.reshape(-1, 2).T, 1e-10)


ALLOCATION = "NRT_MemInfo_alloc"


def test_sine_and_cosine_are_those_of_the_c_library_to_rounding() -> None:
    turns = [n * math.pi / 4 + d for n in range(-80, 81) for d in (-1e-9, 0.0, 1e-9, 0.3)]
    for theta in [*turns, 1e-300, 5000.0]:
        s, c = sine_cosine(theta)
        assert abs(s - math.sin(theta)) < 4.5e-16
        assert abs(c - math.cos(theta)) < 4.5e-16


def test_a_torque_at_the_tip_settles_into_the_angles_of_the_springs_in_series() -> None:
    model, load = preset("P2"), make_load(10)
    load.Q_theta[-1] = 0.012
    state = advance(model._replace(alpha=20.0), at_rest(model), load, 60.0)
    assert_close(state.q[2], np.cumsum(0.012 / model.k), 1e-9)


def test_a_fine_chain_bends_into_the_circle_of_a_cantilever_under_an_end_moment() -> None:
    rods, moment = 400, 0.02
    model = preset("P1", rods)
    curvature = moment / (0.0751 * 0.253 / 10)
    base = 0.253 / 20  # the table's base joint counts a whole cell: half a cell of beam before the clamp
    along = np.linspace(0.0, 0.253, 100_001)
    expected = 0.253 * np.array([np.cos(curvature * (base + along)).mean(), np.sin(curvature * (base + along)).mean()])
    theta = np.cumsum(moment / model.k)
    tip = np.array([model.L @ np.cos(theta), model.L @ np.sin(theta)])
    assert np.linalg.norm(tip - expected) < 1e-5


def test_halving_the_step_divides_the_error_by_sixteen() -> None:
    model, load = preset("P1"), make_load(10)
    load.Q_theta[-1] = 0.02
    exact, *tips = (tip_after(model, load, dt) for dt in (1.25e-4, 2e-3, 1e-3))
    coarse, fine = (np.linalg.norm(tip - exact) for tip in tips)
    assert 12.0 < coarse / fine < 20.0


def tip_after(model: RodModel, load: Any, dt: float) -> Array:
    state = advance(model, thrown(model, 1, bend=0.1, speed=0.5), load, 0.4, dt)
    return np.array(tip_of(model, state.q))


def test_constraint_drift_stays_bounded_over_a_minute_of_motion() -> None:
    model, load = preset("P1"), make_load(10)
    state, drift = at_rest(model), []
    for second in np.arange(0.0, 60.0, 0.1):
        load.Q_theta[4], load.Q_theta[-1] = 0.02 * np.sin(7 * second), 0.02 * np.cos(5 * second)
        load.F[:, -1] = np.sin(3 * second), np.cos(2 * second)
        advance(model, state, load, 0.1)
        drift.append(np.abs(Chain(model).phi(state.q.T.ravel())).max())
    assert max(drift[300:]) < 1.1 * max(drift[:300])
    assert max(drift) < 1e-6


def test_a_torn_chain_is_pulled_together_at_baumgartes_rate() -> None:
    model = preset("P1")
    state = at_rest(model)
    state.q[1, 5:] += 1e-3
    gap = [np.abs(Chain(model).phi(advance(model, state, make_load(10), 0.02).q.T.ravel())).max() for _ in range(8)]
    assert gap[0] < 1e-3 * 4.0 * math.exp(-2.0)
    assert gap[-1] < 1e-3 * 20.0 * math.exp(-16.0)


def test_a_state_that_is_not_finite_stays_so_and_a_good_one_recovers_the_same_scratch() -> None:
    model, load, work = preset("P1"), make_load(10), make_work(10)
    bad, good = at_rest(model), thrown(model, 2)
    bad.q[2, 3] = math.nan
    rk4_step(model, load, 1e-3, bad, work)
    assert not np.isfinite(bad.q).all()
    rk4_step(model, load, 1e-3, good, work)
    fresh = thrown(model, 2)
    rk4_step(model, load, 1e-3, fresh, make_work(10))
    assert np.array_equal(good.q, fresh.q)
    assert np.isfinite(good.v).all()


def test_a_step_and_its_ledger_allocate_nothing() -> None:
    @njit(nogil=True, error_model="numpy")
    def step(model: RodModel, state: RodState, load: Any, work: Any, ledger: Ledger, u: Array) -> None:
        rk4_step(model, load, 1e-3, state, work)
        ledger_step(model, state, load, u, 1e-3, work, ledger)

    @njit
    def wasteful(u: Array) -> Array:
        return u + 1.0

    model = preset("P1")
    step(model, at_rest(model), make_load(10), make_work(10), make_ledger(), NO_TORQUE)
    wasteful(NO_TORQUE)
    assert ALLOCATION in "".join(wasteful.inspect_llvm().values())
    assert ALLOCATION not in "".join(step.inspect_llvm().values())


def test_every_constraint_holds_in_the_poses_the_tests_start_from() -> None:
    model = preset("P2", 7)
    state = posed(model, np.linspace(0.1, 3.0, 7), np.linspace(-1.0, 2.0, 7))
    chain, q = Chain(model), state.q.T.ravel()
    assert np.abs(chain.phi(q)).max() < 1e-15
    assert np.abs(chain.jacobian(q) @ state.v.T.ravel()).max() < 1e-15
