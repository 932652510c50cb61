"""The planned references: timing, place and, for every actuator, reach with margin.

Margins hold for every row after the approach: 5 % of each bound on the torques, and S at least 0.15 away from a fold,
as its smallest singular value over its largest, with det S of one sign (P3's steps, which the paper does not run: 4 %,
0.10). At rest, where the approach begins, S is singular and no such margin exists.
"""

from functools import cache

import numpy as np
import pytest

from controller.arrays import Array
from controller.assembly.statics import static_map
from controller.errors import ParameterError
from controller.kernels.control.inverse import REFINE_STEPS
from controller.kernels.model.statics import StaticMap
from controller.reference.feasible.approach import follow
from controller.reference.feasible.reach import static_tips
from controller.reference.library import SWEEP, names, reference
from controller.reference.reference import Reference
from controller.schema.actuator import PRESETS
from controller.schema.parameters import ControllerParameters

SHAPES = ("step", "vu", "vertical_1hz", "horizontal_1hz", "circle_1hz", "sensing_sweep")
DIGITS = tuple(f"digit_{value}" for value in range(10))
CASES = [(actuator, name) for actuator in PRESETS for name in SHAPES + DIGITS]
STRIDE = 10


@cache
def plan(name: str, actuator: str = "P1") -> Reference:
    return reference(name, PRESETS[actuator])


@cache
def observer_map(actuator: str) -> StaticMap:
    return static_map(PRESETS[actuator], ControllerParameters())


def sensitivities(smap: StaticMap, u: Array) -> Array:
    """S (n, 2, 2) by central differences of the static map."""
    h = 1e-7
    columns = [(static_tips(smap, u + h * axis) - static_tips(smap, u - h * axis)) / (2 * h) for axis in np.eye(2)]
    return np.stack(columns, axis=-1)


def speeds(plan: Reference) -> Array:
    return np.linalg.norm(np.diff(plan.p[plan.start :], axis=0), axis=1) / 1e-3


@pytest.mark.parametrize(("actuator", "name"), CASES)
def test_from_rest_on_the_tick_s_own_inverse_follows_every_shape_with_margin(actuator: str, name: str) -> None:
    smap, planned = observer_map(actuator), plan(name, actuator)
    twice = follow(smap, np.repeat(planned.p[::STRIDE], 2, axis=0), np.zeros(2), REFINE_STEPS)
    u, distance = (found[1::2] for found in twice)  # a step of 79 mm takes two ticks
    assert distance.max() < 1e-6
    assert np.abs(static_tips(smap, u) - planned.p[::STRIDE]).max() < 1e-6
    u = u[2000 // STRIDE :]
    used, clear = (0.96, 0.10) if (actuator, name) == ("P3", "step") else (0.95, 0.15)
    assert ((u @ smap.polygon.normals.T) / smap.polygon.bounds).max() < used
    S = sensitivities(smap, u)
    size = np.linalg.svd(S, compute_uv=False)
    assert (size[:, 1] / size[:, 0]).min() > clear
    assert np.linalg.det(S).min() > 0.0


@pytest.mark.parametrize("actuator", PRESETS)
@pytest.mark.parametrize("name", ["vu", "circle_1hz"])
def test_the_approach_leads_from_the_rest_tip_to_the_start_without_speed_at_its_ends(name: str, actuator: str) -> None:
    planned = plan(name, actuator)
    way = planned.p[: planned.start + 1]
    assert planned.start == 2000
    assert way[0] == pytest.approx([PRESETS[actuator].length, 0.0])
    speed = np.linalg.norm(np.diff(way, axis=0), axis=1) / 1e-3
    assert speed[[0, -1]].max() < 1e-4
    assert np.abs(np.diff(speed)).max() / 1e-3 < 1.5
    assert speed.max() < 0.45


@pytest.mark.parametrize("name", [name for name in names() if name != "step"])
def test_a_reference_does_not_jump(name: str) -> None:
    apart = np.linalg.norm(np.diff(plan(name).p, axis=0), axis=1)
    assert apart.max() < 0.45e-3


@pytest.mark.parametrize("name", DIGITS)
def test_a_digit_takes_10_s_at_one_speed(name: str) -> None:
    planned = plan(name)
    assert len(planned.p) == planned.start + 10_000 + 1
    speed = speeds(planned)
    assert 3e-3 * (1 - 1e-6) < np.median(speed) < 18e-3 * (1 + 1e-6)
    assert np.percentile(speed, [1, 99]) == pytest.approx(np.median(speed), rel=1e-3)


def test_vu_covers_its_box_in_25_s_at_5_mm_per_s() -> None:
    planned = plan("vu")
    drawn = planned.p[planned.start :]
    assert drawn.min(axis=0) == pytest.approx([-50e-3, 125e-3], abs=5e-6)
    assert drawn.max(axis=0) == pytest.approx([5e-3, 150e-3], abs=5e-6)
    assert len(drawn) == 25_000 + 1
    assert np.median(speeds(planned)) == pytest.approx(5e-3, rel=1e-4)


@pytest.mark.parametrize(
    ("name", "peak", "acceleration", "run"), [("circle_1hz", 0.188, 1.18, 9000), ("circle_2hz", 0.37, 4.7, 6000)]
)
def test_the_circles_have_the_paper_s_speed_acceleration_and_duration(
    name: str, peak: float, acceleration: float, run: int
) -> None:
    planned = plan(name, "P3")
    assert speeds(planned).max() == pytest.approx(peak, rel=0.02)
    change = np.linalg.norm(np.diff(planned.p[planned.start :], n=2, axis=0), axis=1) / 1e-6
    assert change.max() == pytest.approx(acceleration, rel=0.01)
    assert len(planned.p) == run + 1
    assert planned.velocity_feedforward


@pytest.mark.parametrize(("name", "frequency"), SWEEP.items())
def test_the_frequency_sweep_is_whole_turns_in_at_least_7_s(name: str, frequency: float) -> None:
    planned = plan(name)
    duration = (len(planned.p) - 1 - planned.start) * 1e-3
    turns = duration * frequency
    assert duration >= 7.0 and turns == pytest.approx(round(turns), abs=1e-3)


def test_the_steps_last_3_s_each_and_leave_from_the_left_corner() -> None:
    planned = plan("step")
    assert np.diff([*planned.steps, len(planned.p)]).tolist() == [3000] * 4
    assert planned.start == planned.steps[0]
    apart = np.linalg.norm(np.diff(planned.p, axis=0), axis=1)
    assert (np.flatnonzero(apart > 10e-3) + 1).tolist() == list(planned.steps)
    assert planned.p[planned.start - 1] == pytest.approx(planned.p[-1])


@pytest.mark.parametrize("name", ["vu", "circle_1hz", "digit_0"])
def test_for_p3_a_shape_moves_in_y_only_and_keeps_its_size(name: str) -> None:
    here, there = plan(name), plan(name, "P3")
    moved = there.p[there.start :] - here.p[here.start :]
    assert np.ptp(moved, axis=0).max() < 1e-12
    assert moved[0, 0] == pytest.approx(0.0, abs=1e-12)
    assert moved[0, 1] < 0.0


def test_a_shape_out_of_reach_is_refused_with_the_distance() -> None:
    with pytest.raises(ParameterError, match=r"leaves the reach by \d+\.\d mm"):
        reference("step", PRESETS["P3"].model_copy(update={"u_max": 0.06}))
    short = PRESETS["P1"].model_copy(update={"length": 0.1})
    with pytest.raises(ParameterError, match="out of reach"):
        reference("circle_1hz", short)


def test_an_unknown_reference_is_refused_with_the_known_ones() -> None:
    with pytest.raises(ParameterError, match="digit_0"):
        reference("spiral", PRESETS["P1"])
