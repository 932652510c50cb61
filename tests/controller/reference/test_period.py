"""Frequencies that are found, and paths that have none."""

import math

import numpy as np
import pytest

from controller.arrays import Array
from controller.reference.period import rhythm, strongest

DT = 1e-3


def frequency_of(p: Array, dt: float) -> float | None:
    found = rhythm(p, dt)
    return found and found.frequency


def circle(frequency: float, seconds: float, ratio: int = 1) -> Array:
    """A circle of 60 mm; with `ratio` 2 an eight."""
    angle = 2.0 * math.pi * frequency * np.arange(0.0, seconds, DT)
    return 0.03 * np.column_stack([np.cos(angle), np.sin(ratio * angle)])


@pytest.mark.parametrize("frequency", [0.25, 1.0 / 3.0, 0.7, 1.0, 2.0, 7.7])
def test_the_frequency_of_a_repeated_shape_is_found_between_the_ticks_and_in_noise(frequency: float) -> None:
    noise = np.random.default_rng(0).normal(0.0, 1e-4, (9000, 2))
    for path in (circle(frequency, 9.0), circle(frequency, 9.0, 2), circle(frequency, 9.0) * [1.0, 0.0]):
        assert frequency_of(path, DT) == pytest.approx(frequency, rel=1e-5)
        assert frequency_of(path + noise[: len(path)], DT) == pytest.approx(frequency, rel=1e-3)


@pytest.mark.parametrize("frequency", [0.3, 0.7, 1.37])
def test_a_path_that_jumps_may_repeat_too(frequency: float) -> None:
    corners = 0.03 * np.sign(circle(frequency, 9.0) + 1e-9)
    assert frequency_of(corners, DT) == pytest.approx(frequency, rel=1e-3)


def test_one_and_a_half_periods_are_needed() -> None:
    assert frequency_of(circle(0.5, 3.0), DT) == 0.5
    assert frequency_of(circle(0.5, 2.9), DT) is None


@pytest.mark.parametrize("turns", [3, 10, 40])
def test_a_path_that_only_comes_near_itself_has_no_frequency(turns: int) -> None:
    t = np.arange(0.0, 9.0, DT)
    grows = circle(1.0, 9.0) * (1.0 + 0.3 * t)[:, None]
    drifts = circle(1.0, 9.0) + 0.003 * t[:, None]
    spiral = circle(turns / 9.0, 9.0) * (0.2 + 0.1 * t)[:, None]
    decay = circle(2.0, 9.0) * np.exp(-0.05 * t)[:, None]
    walk = np.cumsum(np.random.default_rng(0).normal(0.0, 1e-4, (9000, 2)), axis=0)
    for path in (grows, drifts, spiral, decay, walk, walk[:7], np.full((9000, 2), 0.1)):
        assert frequency_of(path, DT) is None


def test_the_part_that_repeats_is_that_at_the_end_and_most_of_the_path() -> None:
    from_rest = np.vstack([np.linspace([0.25, 0.0], [0.03, 0.0], 2000, endpoint=False), circle(1.0, 9.0)])
    assert rhythm(from_rest, DT) == (1.0, 2000)
    line = np.vstack([np.linspace([0.25, 0.0], [0.03, 0.0], 9000, endpoint=False), circle(1.0, 6.0)])
    assert rhythm(line, DT) is None


def test_the_strongest_swing_is_a_multiple_or_the_period_s_own() -> None:
    eight = circle(0.5, 5.0, 2)
    assert [strongest(eight[:, j], 0.5, DT) for j in range(2)] == [0.5, 1.0]
    assert strongest(np.full(5000, 0.1), 0.5, DT) == strongest(eight[:1500, 1], 0.5, DT) == 0.5
