"""What is learned of a path by repeating it."""

import math
from itertools import product

import numpy as np
import pytest

from controller.errors import DataError
from controller.reference.learning import (
    CUTOFF,
    FALLS,
    GAMMA,
    Lesson,
    led_in,
    path_errors,
    smoothed,
    taught,
    untaught,
)
from controller.reference.torques import CUTOFF_HZ, Late, late_of, slow
from controller.schema.actuator import PRESETS
from controller.schema.parameters import ControllerParameters

P1, CONTROLLER = PRESETS["P1"], ControllerParameters()
DT, N = CONTROLLER.dt, 2000
T = DT * np.arange(N)
SLOW = np.column_stack([np.sin(2.0 * np.pi * T), 1.0 - np.cos(2.0 * np.pi * T)]) * 10e-3
QUICK = np.column_stack([np.sin(2.0 * np.pi * 8.0 * T), np.zeros(N)]) * 10e-3


def lesson() -> Lesson:
    return untaught(N, P1, CONTROLLER)


def test_the_first_repeat_is_the_plan_alone() -> None:
    first = lesson()
    assert not first.next.any() and not first.best.any() and math.isinf(first.rmse) and not first.over


def test_what_is_left_of_the_error_is_added_where_it_is_slow() -> None:
    after = taught(lesson(), SLOW + QUICK, DT)
    assert np.abs(after.next - GAMMA * SLOW)[200:-200].max() < 0.3e-3
    assert (after.repeats, after.rmse) == (1, pytest.approx(np.sqrt(((SLOW + QUICK) ** 2).sum(axis=1).mean())))


def test_a_repeat_that_is_worse_is_forgotten_and_the_next_is_more_careful() -> None:
    better = taught(taught(lesson(), SLOW, DT), 0.5 * SLOW, DT)
    worse = taught(better, 0.6 * SLOW, DT)
    assert worse.best is better.best and worse.rmse == better.rmse
    assert worse.cutoff == FALLS * better.cutoff
    assert np.abs(worse.next - better.best).max() <= GAMMA * 0.5 * np.abs(SLOW).max() * 1.01


@pytest.mark.parametrize("error", [None, 2.0 * SLOW], ids=["broken off", "worse"])
def test_what_is_kept_is_never_worse_and_it_comes_to_an_end(error: np.ndarray | None) -> None:
    found = taught(lesson(), SLOW, DT)
    best = found.best
    for _ in range(20):
        found = taught(found, error, DT)
    assert found.over and found.best is best and found.next is best


def test_a_first_repeat_that_is_broken_off_teaches_nothing() -> None:
    found = taught(lesson(), None, DT)
    assert not found.next.any() and math.isinf(found.rmse) and found.repeats == 1


def test_the_correction_is_bounded_by_the_arm() -> None:
    found = lesson()
    for k in range(100):
        found = taught(found, SLOW * (10.0 - 1e-3 * k), DT)
    assert np.linalg.norm(found.next, axis=1).max() == pytest.approx(0.25 * P1.length)


def test_a_lap_goes_on_where_it_ends() -> None:
    lap = np.column_stack([T, -T]) * 1e-3  # a saw tooth, if it is repeated
    once, over = smoothed(lap, 3.0, DT), smoothed(lap, 3.0, DT, laps=True)
    assert abs(once[0, 0] - once[-1, 0]) > 1.5e-3
    assert abs(over[0, 0] - over[-1, 0]) < 0.1e-3


def test_an_error_of_another_path_is_refused() -> None:
    with pytest.raises(DataError, match="1999 rows of error for a path of 2000"):
        taught(lesson(), SLOW[1:], DT)


def test_the_correction_comes_in_before_the_path() -> None:
    c = np.tile([1e-3, -2e-3], (5, 1))
    lead = led_in(c, 500, DT)
    assert not lead[:300].any() and lead[-1] == pytest.approx(c[0], rel=1e-3)
    assert np.abs(np.diff(lead, axis=0)).max() < 2e-3 * 1.6 * DT / 0.2
    assert led_in(c, 0, DT).shape == (0, 2)


def test_the_tip_is_taken_for_when_it_was_seen() -> None:
    """A camera at 100 Hz, whose image is 7 ms old when it comes in, and is held until the next one."""
    true = SLOW
    ticks = np.arange(N)
    captured = (ticks - 7) // 10 * 10
    seen = np.where(captured[:, None] >= 0, true[np.maximum(captured, 0)], np.nan)
    found = path_errors(np.zeros((N, 2)), seen, (ticks - captured) * DT, DT)
    assert found is not None
    assert np.abs(found + true)[: N - 20].max() < 0.01e-3
    assert path_errors(np.zeros((N, 2)), np.where(ticks[:, None] % 5, true, np.nan), np.zeros(N), DT) is None


FAMILY = tuple(product((0.8, 1.0, 1.2), (0.8, 1.0, 1.2), (0.1, 0.25, 0.5), (0.04, 0.05, 0.07), (0.7, 1.0, 1.3)))
"""Factors on stiffness and torque, damping ratio, dead time [s], factor on the chambers' time constant."""


@pytest.mark.parametrize("name", PRESETS)
def test_no_arm_of_the_family_learns_a_larger_error_below_half_the_first_mode(name: str) -> None:
    """|1 - gamma Q G| <= 1 at every frequency: linear, about rest, without feedback.

    From the cutoff that the second worse repeat leads to; before, the first mode of an arm of less damping may be too
    much, and the repeat that is worse is what tells.
    """
    model = late_of(PRESETS[name], CONTROLLER)
    f = np.linspace(0.0, 30.0, 6000)
    cutoff = CUTOFF * FALLS**2 * model.omega / (2.0 * math.pi)
    nominal = response(f, model, 1.0)
    for k, gain, zeta, dead_time, lag in FAMILY:
        arm = Late(model.omega * math.sqrt(k), zeta, lag * model.tau, dead_time, DT)
        G = response(f, arm, gain / k) / nominal * slow(f, CUTOFF_HZ)
        left = np.abs(1.0 - GAMMA * slow(f, cutoff) * G)
        assert left.max() < 1.0 + 5e-3, (k, gain, zeta, dead_time, lag, f[left.argmax()])
        assert left[f < 0.5 * cutoff].max() < 0.75, (k, gain, zeta, dead_time, lag)


def response(f: np.ndarray, arm: Late, gain: float) -> np.ndarray:
    """From torque to tip, of one mode."""
    s = 2j * np.pi * f
    mode = 1.0 + 2.0 * arm.zeta * s / arm.omega + (s / arm.omega) ** 2
    return np.asarray(gain * np.exp(-s * arm.dead_time) / mode / (1.0 + arm.tau * s))
