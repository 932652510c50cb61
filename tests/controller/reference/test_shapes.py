"""The shapes against the sizes that the paper gives, and closed forms of their lengths."""

import numpy as np
import pytest
from scipy.special import ellipe

from controller.reference import shapes

TURNS = np.linspace(0.0, 1.0, 4001)


@pytest.mark.parametrize("value", range(2, 10))
def test_the_digits_two_to_nine_fill_a_square_of_30_mm(value: int) -> None:
    path = shapes.digit(value)
    assert path.min(axis=0) == pytest.approx([-15e-3, -15e-3])
    assert path.max(axis=0) == pytest.approx([15e-3, 15e-3])


def test_the_one_is_a_vertical_line_of_30_mm() -> None:
    assert np.ptp(shapes.digit(1), axis=0) == pytest.approx([0.0, 30e-3])


def test_the_zero_is_an_ellipse_of_60_by_30_mm_as_long_as_the_elliptic_integral_says() -> None:
    path = shapes.digit(0)
    assert np.ptp(path, axis=0) == pytest.approx([30e-3, 60e-3], rel=1e-6)
    assert path[-1] == pytest.approx(path[0], abs=1e-12)
    assert shapes.lengths(path)[-1] == pytest.approx(4 * 30e-3 * ellipe(0.75), rel=1e-5)


def test_in_10_s_the_digits_are_drawn_at_3_to_18_mm_per_s() -> None:
    speeds = [shapes.lengths(shapes.digit(value))[-1] / 10.0 for value in range(10)]
    assert min(speeds) == pytest.approx(3e-3)
    assert max(speeds) == pytest.approx(18e-3)


def test_vu_spans_55_mm_by_25_mm_with_125_mm_of_path_in_letters_of_equal_width() -> None:
    path = shapes.vu()
    assert path.min(axis=0) == pytest.approx([0.0, 0.0], abs=1e-9)
    assert path.max(axis=0) == pytest.approx([55e-3, 25e-3])
    assert shapes.lengths(path)[-1] == pytest.approx(125e-3, rel=1e-5)
    assert path[2, 0] - path[0, 0] == pytest.approx(path[-1, 0] - path[3, 0])
    assert path[3, 0] > path[2, 0]


def test_points_along_a_path_are_evenly_spaced() -> None:
    points = shapes.along(shapes.digit(1), np.linspace(0.0, 1.0, 31))
    assert np.linalg.norm(np.diff(points, axis=0), axis=1) == pytest.approx(np.full(30, 1e-3))


def test_circle_and_lines_measure_60_mm() -> None:
    assert np.linalg.norm(shapes.circle(TURNS), axis=1) == pytest.approx(np.full(4001, 30e-3))
    assert np.ptp(shapes.vertical(TURNS), axis=0) == pytest.approx([0.0, 60e-3])
    assert np.ptp(shapes.horizontal(TURNS), axis=0) == pytest.approx([60e-3, 0.0])


def test_the_circle_runs_counter_clockwise_from_the_top() -> None:
    x, y = shapes.circle(TURNS).T
    assert (x[0], y[0]) == pytest.approx((0.0, 30e-3))
    assert np.trapezoid(x, y) == pytest.approx(np.pi * 30e-3**2, rel=1e-4)


def test_the_sweep_is_an_arc_through_its_place_about_its_pivot() -> None:
    points = shapes.sweep(TURNS)
    away = points - shapes.SWEEP_PIVOT
    assert np.linalg.norm(away, axis=1) == pytest.approx(np.full(4001, np.hypot(30e-3, 140e-3)))
    assert np.rad2deg(np.ptp(np.arctan2(away[:, 1], away[:, 0]))) == pytest.approx(50.0)
    assert points[0] == pytest.approx([0.0, 0.0], abs=1e-12)


def test_the_diamond_starts_at_the_top_and_turns_clockwise_in_equal_steps() -> None:
    corners = shapes.diamond()
    assert corners[0, 0] == 0.0
    assert corners[0, 1] == corners[:, 1].max()
    steps = np.diff(np.vstack([corners[-1], corners]), axis=0)
    assert np.linalg.norm(steps, axis=1) == pytest.approx(np.full(4, np.sqrt(2) * shapes.DIAMOND))
    (a, b), (c, d) = steps[:2]
    assert a * d - b * c < 0.0
