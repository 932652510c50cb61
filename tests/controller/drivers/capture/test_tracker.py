"""Which point belongs to which rod, angles to a backbone, and the frame between camera and plane."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from controller.arrays import Array
from controller.drivers.device import Angles, Sample
from controller.drivers.tracker import POINTS_MAX, Tracker, along, fitted_frame
from controller.schema.hardware import Frame, MotionCapture
from controller.virtual.rig import seen_by_camera

L = 0.25
RODS = tuple(range(1, 11))


def arc(bend: float) -> Array:
    """Sensors (10,2) [m] of a backbone of even curvature that turns by `bend` [rad]."""
    s = L * np.arange(1, 11) / 10
    if abs(bend) < 1e-9:
        return np.column_stack((s, np.zeros(10)))
    k = bend / L
    return np.column_stack((np.sin(k * s) / k, (1 - np.cos(k * s)) / k))


def tracker(expected: Array, **asked: object) -> Tracker:
    fields: dict[str, object] = {"driver": "natnet", "rods": RODS, **asked}
    return Tracker(MotionCapture.model_validate(fields), L, lambda: expected)


def sample(points: Array, labels: tuple[str, ...] = (), quality: Array | None = None) -> Sample:
    return Sample(1, points, labels, quality)


@settings(deadline=None)
@given(st.permutations(range(10)), st.floats(-3.0, 3.0), st.floats(-0.15, 0.15))
def test_unnamed_points_in_any_order_find_their_rods_near_where_the_observer_expects_them(
    order: list[int], bend: float, off: float
) -> None:
    truth = arc(bend + off)
    assert np.allclose(tracker(arc(bend)).markers(sample(truth[order])), truth)


def test_points_that_the_camera_swaps_are_told_apart_again() -> None:
    truth = arc(1.0)
    swapped = truth.copy()
    swapped[[4, 8]] = truth[[8, 4]]
    assert np.allclose(tracker(truth).markers(sample(swapped)), truth)


def test_named_points_are_believed_wherever_they_are() -> None:
    truth = arc(1.0)
    found = tracker(arc(-2.0), labels={"tip": 10}).markers(sample(truth[[9]], ("tip",)))
    assert np.allclose(found[9], truth[9])
    assert np.isnan(found[:9]).all()


def test_ghosts_find_no_rod_and_are_counted() -> None:
    truth = arc(0.5)
    ghosts = np.array([[-0.2, 0.3], [0.1, -0.4]])
    one = tracker(truth)
    assert np.allclose(one.markers(sample(np.vstack((ghosts, truth)))), truth)
    assert one.strangers == 2


def test_a_ghost_beside_a_marker_takes_its_place_only_where_it_is_nearer() -> None:
    truth = arc(0.5)
    found = tracker(truth).markers(sample(np.vstack((truth[9] + 0.01, truth))))
    assert np.allclose(found, truth)


def test_a_hidden_marker_leaves_its_rod_without_one_and_the_others_with_theirs() -> None:
    truth = arc(0.8)
    found = tracker(truth, gate=0.01).markers(sample(np.delete(truth, 5, axis=0)))
    assert np.isnan(found[5]).all()
    assert np.allclose(np.delete(found, 5, axis=0), np.delete(truth, 5, axis=0))


@pytest.mark.parametrize("points", [np.zeros((0, 3)), np.full((4, 3), math.nan), np.full((3, 2), math.inf)])
def test_frames_of_nothing_are_frames_without_markers(points: Array) -> None:
    assert np.isnan(tracker(arc(0.0)).markers(sample(points))).all()


def test_before_the_first_estimate_no_unnamed_point_finds_a_rod() -> None:
    assert np.isnan(tracker(np.full((10, 2), math.nan)).markers(sample(arc(0.0)))).all()


def test_points_of_too_little_quality_count_as_not_seen() -> None:
    truth, quality = arc(0.3), np.linspace(0.1, 1.0, 10)
    found = tracker(truth, quality_min=0.55).markers(sample(truth, (), quality))
    assert np.isnan(found[:5]).all()
    assert np.allclose(found[5:], truth[5:])


def test_a_flood_of_points_is_cut_off() -> None:
    one = tracker(arc(0.0))
    one.markers(sample(np.zeros((50 * POINTS_MAX, 3))))
    assert one.strangers < POINTS_MAX


@settings(deadline=None)
@given(st.floats(-4.0, 4.0))
def test_angles_along_an_even_bend_give_its_backbone(bend: float) -> None:
    arcs = np.linspace(0.025, L, 10)
    assert np.allclose(along(Angles(1, arcs, bend * arcs / L), L), arc(bend), atol=2e-6)


def test_an_angle_that_is_not_known_is_as_if_it_had_no_sensor() -> None:
    arcs = np.array([0.1, 0.15, 0.25])
    whole, lost = np.array([0.4, 0.6, 1.0]), np.array([0.4, math.nan, 1.0])
    assert np.allclose(along(Angles(1, arcs, lost), L), along(Angles(1, arcs, whole), L))
    assert np.isnan(along(Angles(1, arcs, np.full(3, math.nan)), L)).all()


def turned(seed: int) -> tuple[Frame, Array]:
    """A frame of a camera somewhere in the room, and its rotation (3,3)."""
    rng = np.random.default_rng(seed)
    R = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    R *= np.sign(np.linalg.det(R))
    return Frame(axes=(tuple(R[0]), tuple(R[1])), origin=tuple(rng.uniform(-1, 1, 2))), R


@pytest.mark.parametrize("seed", range(20))
def test_a_frame_is_found_again_from_three_touched_places(seed: int) -> None:
    frame = turned(seed)[0]
    plane = np.array([[0.0, 0.0], [L, 0.0], [0.2, 0.08]])
    found = fitted_frame(seen_by_camera(plane, frame), plane)
    points = np.random.default_rng(seed).uniform(-0.3, 0.3, (50, 2))
    back = seen_by_camera(points, frame) @ np.array(found.axes).T + found.origin
    assert np.abs(back - points).max() < 1e-9


def test_a_frame_from_places_on_one_line_is_refused() -> None:
    plane = np.array([[0.0, 0.0], [0.1, 0.0], [0.25, 0.0]])
    with pytest.raises(ValueError, match="one line"):
        fitted_frame(seen_by_camera(plane, turned(1)[0]), plane)
