"""Where the shape of a path begins, and whether it steps or repeats."""

import math

import numpy as np
import pytest

from controller.arrays import Array
from controller.reference.feasible.course import course, torn
from controller.reference.library import reference
from controller.schema.actuator import PRESETS

DT = 1e-3
REST, CENTRE = np.array([0.253, 0.0]), np.array([0.03, 0.14])


def led(shape: Array, straight: bool = False) -> Array:
    """`shape` (n, 2) [m] after 2 s from rest to its first point, smoothly or at constant speed."""
    s = np.arange(2000)[:, None] / 2000
    weight = s if straight else s**3 * (10.0 - 15.0 * s + 6.0 * s * s)
    return np.vstack([REST + weight * (shape[0] - REST), shape])


def swinging(fx: float, fy: float, seconds: float) -> Array:
    t = np.arange(0.0, seconds, DT)
    return CENTRE + np.column_stack([0.03 * np.cos(2 * math.pi * fx * t), 0.02 * np.sin(2 * math.pi * fy * t + 0.4)])


def spiral(turns: int) -> Array:
    angle = 2.0 * math.pi * turns * np.arange(10_000)[:, None] / 10_000
    return CENTRE + (0.005 + 0.003 * angle / turns) * np.hstack([np.cos(angle), np.sin(angle)])


def polygon() -> Array:
    corners = CENTRE + 0.03 * np.array([[0, 1], [1, 0], [0, -1], [-1, 0], [0, 1]])
    return np.column_stack([np.interp(np.arange(8001), np.arange(5) * 2000, corners[:, j]) for j in range(2)])


def held(places: list[tuple[float, float]], rows: int = 2000, ramp: int = 1) -> Array:
    """Places [m] in turn, each reached in `ramp` rows."""
    at = np.concatenate([[i * rows, (i + 1) * rows - ramp] for i in range(len(places))])
    return np.column_stack(
        [np.interp(np.arange(len(places) * rows), at, np.repeat(np.array(places)[:, j], 2)) for j in range(2)]
    )


@pytest.mark.parametrize("straight", [False, True])
@pytest.mark.parametrize("frequency", [0.3, 0.47, 1.0, 1.3, 2.0])
def test_a_shape_that_repeats_begins_at_the_end_of_the_file_s_own_approach(frequency: float, straight: bool) -> None:
    for seconds in (1.6 / frequency, 10.0):
        found = course(led(swinging(frequency, frequency, seconds), straight), DT, True)
        assert (found.start, found.frequency, found.axis_frequencies) == (2000, frequency, None)


def test_rounded_or_noisy_points_move_the_start_by_less_than_20_ms() -> None:
    p = led(swinging(1.0, 1.0, 6.0))
    for given in (p.round(4), p.round(3), p + np.random.default_rng(0).normal(0.0, 1e-4, p.shape)):
        found = course(given, DT, True)
        assert found.start == pytest.approx(2000, abs=20)
        assert found.frequency == pytest.approx(1.0, rel=1e-3)


@pytest.mark.parametrize(
    ("fx", "fy", "whole"), [(0.5, 1.0, 0.5), (1.2, 0.8, 0.4), (1.0, 0.7, 0.7), (2.0, 0.3, 0.3), (1.31, 1.7, 1.31)]
)
def test_each_axis_of_a_lissajous_figure_has_its_frequency_even_if_it_does_not_close(
    fx: float, fy: float, whole: float
) -> None:
    found = course(led(swinging(fx, fy, 6.0)), DT, True)
    assert found.start == 2000
    assert found.frequency == whole
    assert found.axis_frequencies == pytest.approx((fx, fy), rel=1e-4)


@pytest.mark.parametrize("hz", [50, 200])
def test_a_coarse_file_of_a_shape_that_never_meets_its_samples_is_understood(hz: int) -> None:
    every = 1000 // hz
    p = led(swinging(0.877, 1.754, 9.0))[: 10_900 + 1]
    at = np.arange(len(p))
    coarse = np.column_stack([np.interp(at, at[::every], p[::every, j]) for j in range(2)])
    found = course(coarse, DT, True)
    assert found.start == pytest.approx(2000, abs=2 * every)
    assert found.axis_frequencies == pytest.approx((0.877, 1.754), rel=1e-3)


@pytest.mark.parametrize("name", ["digit_0", "digit_8", "vu", "vertical_0.25hz", "circle_2hz", "step", "sensing_sweep"])
def test_a_reference_of_the_library_is_understood_with_its_approach_and_without(name: str) -> None:
    planned = reference(name, PRESETS["P1"])
    once = name == "sensing_sweep"  # one period tells nothing
    for begin in (0, 2000):
        found = course(planned.p[begin:], DT, from_rest=begin == 0)
        assert (found.start, found.steps) == (planned.start - begin, tuple(row - begin for row in planned.steps))
        assert found.frequency == (None if once else planned.frequency)


@pytest.mark.parametrize("shape", [spiral(3), spiral(30), polygon()])
def test_what_does_not_repeat_begins_where_the_approach_pauses_or_after_two_seconds(shape: Array) -> None:
    for straight in (False, True):
        assert course(led(shape, straight), DT, True) == (2000, (), None, None)
    assert course(shape, DT, False) == (0, (), None, None)


@pytest.mark.parametrize("ramp", [1, 10, 25])
def test_steps_are_found_in_any_sampling_and_begin_at_the_first_row_that_leaves(ramp: int) -> None:
    steps = held([(0.03, 0.16), (0.05, 0.14), (0.03, 0.12), (0.03, 0.16), (0.05, 0.14), (0.03, 0.12)], ramp=ramp)
    rows = [2000 * i - ramp + 1 for i in range(1, 6)]
    assert course(steps, DT, False) == (rows[0], tuple(rows), None, None)
    after = [2000 + row for row in rows]
    assert course(led(steps), DT, True) == (after[0], tuple(after), None, None)
    assert torn(steps, DT) == (ramp < 25)


def test_a_path_that_moves_between_its_jumps_has_no_steps() -> None:
    saw = CENTRE + 0.04 * np.column_stack([np.arange(6000) % 1000 / 1000, np.zeros(6000)])
    found = course(saw, DT, False)
    assert found.steps == () and found.frequency == pytest.approx(1.0, rel=1e-3)
    assert torn(saw, DT) and not torn(swinging(2.0, 2.0, 3.0), DT)


def test_what_is_said_is_not_looked_for() -> None:
    p = led(swinging(0.5, 0.5, 2.4))
    assert course(p, DT, True).frequency is None
    assert course(p, DT, True, frequency=0.5)[::2] == (2000, 0.5)
    assert course(p, DT, True, start=1500, frequency=0.5)[::2] == (1500, 0.5)
    assert course(held([(0.03, 0.16), (0.05, 0.14), (0.03, 0.12)]), DT, False, start=3000)[:2] == (3000, (4000,))
