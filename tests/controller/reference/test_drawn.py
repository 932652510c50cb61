"""From points in a file to a reference: timing, approach, reach."""

import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from controller.arrays import Array
from controller.assembly.statics import static_map
from controller.errors import DataError, ParameterError
from controller.kernels.model.statics import StaticMap
from controller.reference.drawn import Wish, drawn
from controller.reference.feasible.reach import reach_map
from controller.reference.feasible.within_reach import Carried, projected
from controller.reference.library import reference
from controller.reference.path_file import Samples
from controller.reference.reference import Reference
from controller.schema.actuator import PRESETS
from controller.schema.parameters import ControllerParameters, RigParameters

P1 = PRESETS["P1"]


@cache
def observer_map() -> StaticMap:
    return static_map(P1, ControllerParameters())


def taken(t: Array, p: Array, wish: Wish | None = None, actuator: str = "P1") -> tuple[Reference, Carried]:
    samples = Samples(Path("path.csv"), t, p, np.arange(2, len(t) + 2))
    return drawn(samples, PRESETS[actuator], wish or Wish())


def circle(t: Array) -> Array:
    angle = 2.0 * math.pi * t
    return np.column_stack([0.03 + 0.03 * np.cos(angle), 0.14 + 0.03 * np.sin(angle)])


@pytest.mark.parametrize(("name", "actuator"), [("circle_1hz", "P1"), ("circle_1hz", "P2"), ("digit_3", "P3")])
def test_a_shape_of_the_library_given_as_points_is_its_reference_to_the_last_bit(name: str, actuator: str) -> None:
    planned = reference(name, PRESETS[actuator])
    p = planned.p[planned.start :]
    found, _ = taken(np.round(7.0 + 1e-3 * np.arange(len(p)), 3), p, actuator=actuator)
    assert np.array_equal(found.p, planned.p)
    assert (found.start, found.frequency) == (planned.start, planned.frequency)
    assert found.velocity_feedforward == planned.velocity_feedforward


def test_uneven_and_slow_samples_are_joined_by_straight_lines_at_1_khz() -> None:
    t = np.sort(np.random.default_rng(0).uniform(3.0, 5.0, 150))
    found, _ = taken(t, circle(t))
    ticks = t[0] + 1e-3 * np.arange(len(found.p) - found.start)
    assert ticks[-1] <= t[-1] < ticks[-1] + 1e-3
    for j in range(2):
        assert found.p[found.start :, j] == pytest.approx(np.interp(ticks, t, circle(t)[:, j]), abs=1e-9)


def test_a_path_that_begins_at_rest_has_no_approach() -> None:
    t = np.linspace(0.0, 1.0, 101)
    bow = 0.5 * math.pi * t
    found, _ = taken(t, 0.15 * np.column_stack([np.sin(bow) * 0.2, bow]) + [P1.length, 0.0], Wish(project=True))
    assert found.start == 0
    assert len(found.p) == 1001


def test_the_shape_may_be_said_to_begin_later() -> None:
    t = np.arange(0.0, 3.0, 0.01)
    assert taken(t, circle(t), Wish(start=0.5))[0].start == 2500
    with pytest.raises(ParameterError, match=r"start = 2.99 s, but path.csv ends after 2.99 s"):
        taken(t, circle(t), Wish(start=2.99))
    with pytest.raises(ParameterError, match=r"start = nan s is outside \[0, inf\)"):
        Wish(start=math.nan)


def test_k_ff_follows_the_period_unless_it_is_said() -> None:
    t = np.arange(0.0, 3.0, 0.01)
    assert taken(t, circle(t))[0].velocity_feedforward
    assert not taken(t, circle(t), Wish(velocity_feedforward=False))[0].velocity_feedforward
    once = taken(t[:100], circle(t[:100]))[0]
    assert once.frequency is None and not once.velocity_feedforward
    assert taken(t[:100], circle(t[:100]), Wish(frequency=1.0))[0].frequency == 1.0
    with pytest.raises(ParameterError, match=r"frequency = 0 Hz is outside \[0.01, 100\]"):
        Wish(frequency=0.0)


def test_a_path_out_of_reach_is_refused_with_line_time_and_distance_or_projected() -> None:
    t = np.arange(0.0, 4.0, 0.05)
    away = np.column_stack([0.05 + 0.05 * t, np.full(t.size, 0.14)])
    with pytest.raises(
        ParameterError, match=r"between lines 6\d and 6\d \(t = 3.\d+ s\): .* is 0.1\d* mm out of the reach of P1"
    ):
        taken(t, away)
    found, path = taken(t, away, Wish(project=True))
    assert path.distance.max() == pytest.approx(29e-3, abs=10e-3)
    assert (found.p[found.start :] == path.p).all()
    assert projected(observer_map(), path.p[path.distance > 0.0][::50]).distance.max() < 1e-4


@pytest.mark.parametrize("p", [(0.02, 0.02), (0.03, 0.0)])
def test_a_point_in_the_hole_is_as_far_from_its_projection_as_from_the_reach(p: tuple[float, float]) -> None:
    """The reach is the image of a grid of torques, about as dense as the tolerance here."""
    image = reach_map(RigParameters(), 301).p.reshape(-1, 2)
    nearest = np.linalg.norm(image - p, axis=1).min()
    assert nearest > 10e-3
    assert projected(observer_map(), np.array([p, p])).distance[0] == pytest.approx(nearest, abs=1e-3)


@pytest.mark.parametrize(
    ("t", "scale", "complaint"),
    [
        (np.arange(0.0, 400.0, 1.0), 1.0, r"t runs over 399 s, the rig's memory holds 297.999 s"),
        (np.array([0.0, 5e-4]), 1.0, "t runs over 0.5 ms, less than a tick of 1 ms"),
        (np.arange(0.0, 2.0, 0.1), 1e3, r"line 2: \(60, 140\) m is more than 3 lengths of P1 .* are x and y in m\?"),
    ],
)
def test_too_long_too_short_and_in_mm_is_said(t: Array, scale: float, complaint: str) -> None:
    with pytest.raises((DataError, ParameterError), match=complaint):
        taken(t, scale * circle(t))
