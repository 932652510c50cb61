"""When a loop counts as stable: made-up tips, and the twin with gains that are plainly too high or low."""

import math
from dataclasses import replace

import numpy as np
import pytest

from controller.arrays import Array
from controller.assembly.controllers.registry import with_controller
from controller.research.calibration.margins import (
    GROWTH_MAX,
    MORE_DELAY,
    SECOND,
    SWING_MAX,
    Margin,
    Trial,
    left_over,
    measure_margin,
    stop,
    strained,
    wobble,
)
from controller.research.calibration.predictions import attempt
from controller.schema.parameters import ControllerParameters, RigParameters, SafetyLimits, Settings, TwinParameters
from controller.simulation.case import SPRINGS, Setup
from controller.simulation.run import run

pytestmark = pytest.mark.keyed()

STOP = stop("P1", ControllerParameters())
TRIAL = Trial("P1", "stop", "gain")
CALM = Margin(TRIAL, 1e-4, 0.9, 1.0)
TWIN = TwinParameters(
    kappa=17.4,
    zeta=0.5,
    torque_gain=(1.1, 1.1),
    creep=(0.0, 0.0),
    creep_time=(0.15, 3.5),
    friction=0.02,
    hysteresis=0.0,
    set_curvature=(0.0, 0.0),
    hysteresis_bend=0.5,
    inflate_time=0.044,
    exhaust_time=0.05,
)
"""Every number of the fit, so that these tests hold whatever the fit is."""


def gains(K_P: float, K_I: float) -> Setup:
    own = Settings(K_P=(K_P, K_P), K_I=(K_I, K_I), K_FF=(0.05, 0.05), **SPRINGS)
    return Setup(TWIN, gains=with_controller(own, "letter"))


def swinging(rate: float, size: float = 1e-3) -> Array:
    """The stopped circle with a 1.7 Hz swing on it that grows by exp(`rate`) a second, and is `size` at the end."""
    t = np.arange(len(STOP.p)) * 1e-3
    swing = size * np.exp(rate * (t - t[-1])) * np.sin(2 * np.pi * 1.7 * t)
    return STOP.p + np.stack([0.0 * swing, swing], axis=1)


def test_what_repeats_and_what_drifts_home_is_no_oscillation() -> None:
    t = np.linspace(0.0, 1.0, SECOND)[:, None]
    assert wobble(0.02 * np.exp(-t) * np.ones(2)) < 3e-4
    assert all(swing == pytest.approx(0.0, abs=1e-12) for pair in left_over(STOP.p, STOP) for swing in pair)


def test_growth_is_seen_in_the_hold_and_in_the_laps() -> None:
    for rate in (-1.0, 1.0):
        for before, last in left_over(swinging(rate), STOP):
            assert math.log(last / before) == pytest.approx(rate, abs=0.25)


def test_the_penalty_begins_before_the_bound_and_grows_beyond() -> None:
    assert CALM.penalty == 0.0 and CALM.kept
    swings = [replace(CALM, swing=share * SWING_MAX) for share in (0.89, 1.0, 1.1, 3.0)]
    growths = [replace(CALM, swing=2.0e-3, growth=share * GROWTH_MAX) for share in (0.89, 1.0, 1.1, 3.0)]
    for row in (swings, growths):
        penalties = [margin.penalty for margin in row]
        assert penalties[0] == 0.0 < 1.0 < penalties[1] < penalties[2] < penalties[3]
        assert [margin.kept for margin in row] == [True, True, False, False]
    broken = [Margin(TRIAL, math.nan, math.nan, lasted) for lasted in (0.9, 0.1)]
    assert swings[-1].penalty < broken[0].penalty < broken[1].penalty and not broken[0].kept


def test_noise_that_grows_is_no_instability() -> None:
    assert replace(CALM, swing=0.9e-3, growth=GROWTH_MAX).penalty == 0.0


def test_the_strain_is_half_as_much_gain_more_or_15_ms_more_dead_time() -> None:
    setup = gains(0.4, 1.0)
    more, later = strained(setup, "gain"), strained(setup, "delay")
    assert more.gains.K_P[0] == pytest.approx(0.6) and more.gains.K_FF[1] == pytest.approx(0.075)
    assert more.twin == setup.twin and later.gains == setup.gains
    assert later.twin.dead_time == pytest.approx(setup.twin.dead_time + MORE_DELAY) and MORE_DELAY == 0.015


def test_low_gains_keep_their_margin_and_absurd_ones_do_not() -> None:
    low, high = (measure_margin(TRIAL, setup, 0) for setup in (gains(0.15, 0.4), gains(2.0, 12.0)))
    assert low.kept and low.penalty == 0.0
    assert not high.kept and high.penalty > 3.0


def test_an_attempt_is_the_same_run_and_says_how_far_a_broken_one_came() -> None:
    parameters, short = RigParameters(twin=TWIN), replace(STOP, p=STOP.p[: 3 * SECOND])
    rows, lasted = attempt(parameters, short, Settings(), 5)
    assert lasted == 1.0 and rows.tobytes() == run(parameters, short, Settings(), 5).tobytes()
    impatient = parameters.model_copy(update={"limits": SafetyLimits(error_max=1e-4, error_time=0.1)})
    assert 0.0 < attempt(impatient, short, Settings(), 5).lasted < 1.0
