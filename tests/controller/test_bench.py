"""The benchmark measures what it says, and says what it lacks."""

import importlib

import numpy as np
import pytest

from controller.actuator import PRESETS
from controller.build import build_rod
from controller.errors import TendrilError
from controller.experiments.bench import (
    bent,
    mujoco_tip_difference,
    run_steps,
    stable_step,
    time_beside_mujoco,
    time_chain,
)
from controller.experiments.tick_bench import tick_us
from controller.kernels.rod import make_load, make_work
from controller.kernels.statics import static_tip, tip_of
from controller.stability import largest_step


def test_the_tips_of_both_engines_agree_to_a_micrometre() -> None:
    assert 0.0 < mujoco_tip_difference() < 1e-6


def test_every_time_is_a_positive_number() -> None:
    row = time_chain(20, 1)
    assert (row["n"], row["integrator"]) == (20, "RK4")
    assert row["dense_step_us"] is not None
    assert time_chain(400, 1)["dense_step_us"] is None
    assert min(row["step_us"], row["dense_step_us"], *time_beside_mujoco(1), tick_us(100)) > 0.0


def test_the_chain_is_let_go_from_its_static_pose() -> None:
    model = build_rod(PRESETS["P1"], 50)
    assert tip_of(model, bent(model, 0.015).q) == pytest.approx(static_tip(model, 0.015, 0.015), abs=1e-12)


def test_the_guessed_step_of_long_chains_is_below_the_computed_bound() -> None:
    model = build_rod(PRESETS["P1"], 160)
    assert 0.5 * largest_step(model) < stable_step(model) < 0.9 * largest_step(model)
    state = bent(model, 0.015)
    run_steps(model, state, make_load(160), stable_step(model), make_work(160), 20_000)
    assert np.isfinite(state.v).all()


def test_a_missing_mujoco_is_named_with_the_way_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise ImportError(name)

    monkeypatch.setattr(importlib, "import_module", missing)
    with pytest.raises(TendrilError, match=r"tendril\[bench\]"):
        mujoco_tip_difference()
