"""Rounding a drawn path: the promised bound, and what has to stay."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controller.arrays import Array
from controller.reference.feasible.smoothing import smoothed
from controller.reference.shapes import along, lengths

SQUARE = 0.05 * np.array([(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)], float)
point = st.tuples(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2))


def distance_to(path: Array, points: Array) -> Array:
    """Of each of `points` (m, 2) from the polyline `path` (n, 2)."""
    a, b = path[:-1], path[1:]
    ab = b - a
    share = np.sum((points[:, None] - a) * ab, axis=2) / np.maximum(np.sum(ab**2, axis=1), 1e-30)
    return np.linalg.norm(points[:, None] - a - np.clip(share, 0, 1)[..., None] * ab, axis=2).min(axis=1)


@settings(max_examples=40, deadline=None)
@given(st.lists(point, min_size=2, max_size=8), st.floats(1e-4, 0.02), st.booleans())
def test_no_point_is_moved_further_than_the_radius(
    corners: list[tuple[float, float]], radius: float, loop: bool
) -> None:
    path = np.array([*corners, *corners[: int(loop)]])
    found = smoothed(path, radius, loop)
    own = (
        along(path, np.linspace(0.0, 1.0, len(found))) if lengths(path)[-1] else np.repeat(path[:1], len(found), axis=0)
    )
    assert np.linalg.norm(found - own, axis=1).max() <= radius + 1e-12


def test_an_open_path_keeps_its_ends_and_its_straight_lines() -> None:
    path = SQUARE[:4]
    found = smoothed(path, 1e-3)
    assert found[[0, -1]] == pytest.approx(path[[0, -1]], abs=1e-15)
    assert found[: len(found) // 4, 1] == pytest.approx(0.0, abs=1e-15)


def test_a_closed_path_meets_itself_in_a_round_corner() -> None:
    found = smoothed(SQUARE, 2e-3, closed=True)
    assert found[0] == pytest.approx(found[-1], abs=1e-15)
    assert (found[0] > 5e-4).all(), "the corner at which it begins is cut like the others"
    before, after = found[0] - found[-2], found[1] - found[0]
    assert before @ after == pytest.approx(np.linalg.norm(before) * np.linalg.norm(after), rel=0.01)


def test_a_corner_comes_nearer_by_the_mean_of_the_hat() -> None:
    corner = smoothed(SQUARE[:3], 1e-3)
    assert distance_to(corner, SQUARE[1:2]) == pytest.approx(1e-3 / np.sqrt(2.0), rel=0.06)


def test_without_a_radius_nothing_changes() -> None:
    assert smoothed(SQUARE, 0.0) is SQUARE
