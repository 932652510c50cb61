"""The benchmark measures what it says, and says what it lacks."""

import importlib
import sys

import numpy as np
import pytest

from controller.assembly.rod import build_rod
from controller.assembly.stability import largest_step
from controller.errors import TendrilError
from controller.kernels.model.block import factorise
from controller.kernels.model.implicit import assemble, make_implicit_work, stage
from controller.kernels.model.rod import make_load, make_work, rotations
from controller.kernels.model.statics import tip_of
from controller.research.bench.bench import mujoco_tip_difference, time_beside_mujoco
from controller.research.bench.dense import dense_step, stage_matrix
from controller.research.bench.elastica_rod import beside_elastica
from controller.research.bench.ensemble_bench import time_ensembles
from controller.research.bench.scaling import RELEASED_AT, bent, run_steps, stable_step, step_us, time_chains
from controller.research.bench.tick_bench import closed_loop
from controller.schema.actuator import PRESETS
from controller.schema.parameters import RigParameters
from tests.controller.chains import advance, assert_close, preset, static, thrown
from tests.controller.statically import static_tip

pytestmark = pytest.mark.keyed()


@pytest.mark.process
def test_the_tips_of_both_engines_agree_to_a_micrometre() -> None:
    assert 0.0 < mujoco_tip_difference() < 1e-6


def test_every_time_is_a_positive_number() -> None:
    rows = time_chains(1, (20, 400))
    assert [(row["integrator"], row["n"]) for row in rows] == [
        ("RK4", 20),
        ("RK4", 400),
        ("implicit", 20),
        ("implicit", 400),
    ]
    assert [row["dense_step_us"] is None for row in rows] == [False, True, False, True]
    times = [time for row in rows for time in (row["step_us"], row["dense_step_us"]) if time is not None]
    ours, theirs = time_beside_mujoco(1)
    assert theirs and min(*times, ours, theirs, *closed_loop(RigParameters(), 0.1)) > 0.0
    assert step_us(rows, "implicit", 400) == rows[3]["step_us"]
    found = time_ensembles(1)
    assert found["implicit_over_rk4"] == found["seconds_per_second"] / found["rk4_seconds_per_second"] > 0.0


def test_the_dense_step_of_the_benchmark_is_the_same_step() -> None:
    model, load = preset("P3"), make_load(10)
    load.Q_theta[-1] = 0.03
    ours, dense, work = thrown(model, 3), thrown(model, 3), make_work(10)
    advance(model, ours, load, 0.1)
    for _ in range(100):
        dense_step(model, dense, load, 1e-3, work)
    assert_close(ours.q, dense.q, 1e-10)


def test_the_dense_solver_is_given_the_system_of_the_implicit_stage() -> None:
    model, g = build_rod(PRESETS["P2"], 7), 3e-4
    state, load, work = bent(model, RELEASED_AT), make_load(7), make_implicit_work(7)
    load.F[:], load.Q_theta[:] = 0.1, 2e-3
    rotations(state.q[2], model.arm, work.a)
    assemble(model, g, work.a, work.block)
    factorise(work.block)
    stage(model, state, load, g, work, work.v)
    hinge = np.eye(7) - np.eye(7, k=-1)
    torque = load.Q_theta - hinge.T @ (model.k * (hinge @ state.q[2]))
    right = np.concatenate([g * load.F[0], g * load.F[1], g * torque, np.zeros(14)])
    solution = np.linalg.solve(stage_matrix(model, work.a, g), right)
    assert work.v == pytest.approx(solution[:21].reshape(3, 7), rel=1e-9, abs=1e-12)


def test_the_chain_is_let_go_from_its_static_pose() -> None:
    model = build_rod(PRESETS["P1"], 50)
    assert tip_of(model, bent(model, RELEASED_AT).q) == pytest.approx(
        static_tip(static(model), RELEASED_AT, RELEASED_AT), abs=1e-12
    )


def test_rk4_stays_finite_with_the_step_that_long_chains_are_timed_with() -> None:
    model = build_rod(PRESETS["P1"], 160)
    assert 0.5 * largest_step(model) < stable_step(model) < 0.9 * largest_step(model)
    state = bent(model, RELEASED_AT)
    run_steps(model, state, make_load(160), stable_step(model), make_work(160), 20_000)
    assert np.isfinite(state.v).all()


def test_a_missing_mujoco_is_named_with_the_way_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise ImportError(name)

    monkeypatch.setattr(importlib, "import_module", missing)
    with pytest.raises(TendrilError, match=r"mujoco is not installed: .*python.* -m pip install 'mujoco>=[\d.]+' "):
        mujoco_tip_difference()
    ours, theirs = time_beside_mujoco(1)
    assert ours > 0.0 and theirs is None


def test_without_pyelastica_there_is_no_figure_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "elastica", None)
    assert beside_elastica() is None


def test_pyelasticas_rod_comes_to_rest_where_ours_does() -> None:
    pytest.importorskip("elastica")
    figures = beside_elastica()
    assert figures is not None
    assert figures["tip_difference_at_rest_m"] < 1e-3
    assert figures["tip_difference_m"] < 1e-2
