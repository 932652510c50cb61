"""Damping from free decays of the rod engine, whose own eigenvalues are the truth."""

import math

import numpy as np
import pytest

from controller.assembly.rod import build_rod
from controller.assembly.stability import natural_modes
from controller.kernels.model.rod import make_load
from controller.kernels.model.statics import tip_of
from controller.research.identification.motion.damping_fit import FreeDecay, fit_damping, model_modes
from controller.schema.actuator import PRESETS, Actuator
from tests.controller.chains import advance, posed

pytestmark = pytest.mark.keyed()

ALPHA, BETA = 0.719, 0.003337
STIFF = PRESETS["P1"].model_copy(update={"k": (0.3, 0.2)})
TRUTH = STIFF.model_copy(update={"alpha": ALPHA, "b": tuple(BETA * k for k in STIFF.k)})


def released(actuator: Actuator, bend: float, seed: int, rods: int = 14) -> FreeDecay:
    """Tip of a chain let go from a bent pose, at 100 Hz with 0.2 mm of noise, in a turned and moved frame."""
    model = build_rod(actuator, rods)
    theta = model.rest + bend * (model.compliance @ np.array([0.05, 0.05]))
    state = posed(model, theta, np.zeros(rods))
    tips = [tip_of(model, advance(model, state, make_load(rods), 0.01, dt=1e-4).q) for _ in range(700)]
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    noise = np.random.default_rng(seed).normal(0.0, 2e-4, (700, 2))
    return FreeDecay(f"decay {seed}", np.arange(700) * 0.01, np.array(tips) @ turn.T + 0.3 + noise)


def first_mode(actuator: Actuator, rods: int) -> complex:
    model = build_rod(actuator, rods)
    modes = natural_modes(model, model.rest)
    return complex(modes[np.argmin(np.abs(modes))])


def test_zeta_alpha_and_beta_come_back_from_the_decays_of_a_finer_chain() -> None:
    fit = fit_damping([released(TRUTH, bend, seed) for seed, bend in enumerate((0.15, -0.12, 0.18))], STIFF)
    found = {one.name: one for one in fit.parameters}
    mode = first_mode(TRUTH, 14)
    zeta = -mode.real / abs(mode)
    assert found["zeta"].value == pytest.approx(zeta, rel=0.02)
    assert found["damped frequency"].value == pytest.approx(abs(mode.imag) / math.tau, rel=0.01)
    assert found["alpha"].value == pytest.approx(ALPHA, rel=0.02)
    assert found["beta"].value == pytest.approx(BETA, rel=0.02)
    assert not any("time scale" in note for note in fit.notes)
    assert fit.actuator.b == pytest.approx(TRUTH.b, rel=0.02)


def test_the_fitted_model_decays_with_the_measured_ratio_and_no_mode_below_the_stated_one() -> None:
    fit = fit_damping([released(TRUTH, 0.15, 1)], STIFF)
    found = {one.name: one.value for one in fit.parameters}
    mode = first_mode(fit.actuator, fit.actuator.table_rods)
    assert -mode.real / abs(mode) == pytest.approx(found["zeta"], rel=0.01)
    assert found["lowest zeta between the modes"] < found["zeta"]


def test_a_model_with_another_time_scale_is_reported() -> None:
    fit = fit_damping([released(TRUTH, 0.15, 1)], PRESETS["P1"])
    assert "time scale is not" in fit.notes[0]


def test_the_modes_of_a_slender_chain_are_those_of_a_cantilever() -> None:
    body = PRESETS["P1"]
    fine = body.model_copy(update={"table_rods": 200, "k": tuple(np.full(200, 1.9e-3 / (body.length / 200)))})
    first, second = model_modes(fine)
    scale = math.sqrt(1.9e-3 / (body.mass / body.length * body.length**4))
    assert first == pytest.approx(3.5160 * scale, rel=0.02)
    assert second == pytest.approx(22.034 * scale, rel=0.02)
