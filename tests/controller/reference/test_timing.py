"""When a drawn path is where: constant speed, and the fastest ride against closed forms."""

import math

import numpy as np
import pytest

from controller.arrays import Array
from controller.reference.feasible.smoothing import smoothed
from controller.reference.feasible.timing import Limits, fastest, steady
from controller.reference.shapes import lengths

DT = 1e-3
LIMITS = Limits(0.2, 1.5)
STAR = 0.03 * np.array([(math.sin(turn), math.cos(turn)) for turn in 0.8 * math.pi * np.arange(6)])


def accelerations(rows: Array) -> Array:
    """Of the ticks [m/s^2], the start from rest and the stop included."""
    v = np.vstack([np.zeros(2), np.diff(rows, axis=0) / DT, np.zeros(2)])
    found: Array = np.linalg.norm(np.diff(v, axis=0), axis=1) / DT
    return found


def test_steady_takes_its_time_and_goes_through_corners_at_one_speed() -> None:
    rows = steady(STAR, 7.0, DT)
    assert len(rows) == 7001
    speed = np.linalg.norm(np.diff(rows, axis=0), axis=1) / DT
    assert np.median(speed) == pytest.approx(lengths(STAR)[-1] / 7.0)
    assert np.sum(speed < 0.999 * np.median(speed)) <= 4, "a tick in which a corner falls"
    for corner in STAR:
        assert np.linalg.norm(rows - corner, axis=1).min() < 1e-4


@pytest.mark.parametrize(
    ("length", "duration"),
    [
        (0.5, 0.5 / LIMITS.speed + LIMITS.speed / LIMITS.acceleration),
        (0.01, 2.0 * math.sqrt(0.01 / LIMITS.acceleration)),
    ],
)
def test_a_line_takes_the_closed_form(length: float, duration: float) -> None:
    ride = fastest(smoothed(np.array([(0.0, 0.0), (length, 0.0)]), 1e-4), LIMITS)
    assert ride.t[-1] == pytest.approx(duration, rel=1e-4)
    assert ride.rows(DT)[-1] == pytest.approx((length, 0.0), abs=1e-12)


def test_a_small_circle_is_ridden_at_the_speed_that_its_curvature_allows() -> None:
    turn = np.linspace(0.0, 6.0 * math.pi, 6000)
    ride = fastest(0.01 * np.column_stack([np.cos(turn), np.sin(turn)]), LIMITS)
    assert np.median(ride.v) == pytest.approx(math.sqrt(LIMITS.acceleration * 0.01), rel=1e-3)


@pytest.mark.parametrize("radius", [1e-4, 1e-3, 5e-3])
@pytest.mark.parametrize("limits", [LIMITS, Limits(0.02, 0.1)])
def test_the_fastest_ride_keeps_its_limits_and_is_at_one_of_them(radius: float, limits: Limits) -> None:
    ride = fastest(smoothed(STAR, radius, closed=True), limits)
    rows = ride.rows(DT)
    speed = np.linalg.norm(np.diff(rows, axis=0), axis=1) / DT
    assert speed.max() <= limits.speed * (1.0 + 1e-6)
    bound = accelerations(rows)
    assert bound.max() <= 1.02 * limits.acceleration
    assert np.mean((speed > 0.98 * limits.speed) | (bound[1:] > 0.9 * limits.acceleration)) > 0.9


def test_a_sharper_corner_is_slower() -> None:
    slow, fast = (fastest(smoothed(STAR, radius, closed=True), LIMITS).t[-1] for radius in (1e-4, 2e-3))
    assert slow > fast
