"""No reference is followed beyond the limits: what is drawn or imported is within them, or refused with its reason."""

import itertools
import math
import os
import re
from functools import partial
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from controller.arrays import Array
from controller.assembly.statics import static_map
from controller.errors import ParameterError
from controller.reference.feasible.reach import static_tips
from controller.reference.library import PLANS
from controller.schema.actuator import PRESETS
from controller.schema.parameters import RigParameters, Settings
from server.drawing.messages import DrawingBody, Wanted
from server.drawing.plan import drawing_plan
from server.drawing.planned import wanted
from server.runs.lap import Leg, Place
from server.runs.laps import allowed_by, first_leg, lap_of, next_leg
from server.runs.messages import PreviewBody
from server.runs.preview import predicted

pytestmark = pytest.mark.keyed()

LIVE, DT, T = Settings(), 1e-3, 20
TORQUE_RATE = 5.0
TOLERANCE = 1.0 + 1e-5
RIGS = {name: RigParameters(actuator=PRESETS[name]) for name in ("P1", "P2", "P3")}
THROUGH = [(0.02, 0.16), (0.02, -0.16)]
"""Through the hole of the reach."""

coordinate = st.floats(-0.25, 0.25)
point = st.tuples(coordinate, st.floats(-0.3, 0.3))


@st.composite
def bodies(draw: Any) -> dict[str, Any]:
    """A drawing of any kind: closed or open, with cusps, through the hole, out of reach, with times or without."""
    kind = draw(st.sampled_from(["any", "through", "cusps", "loop", "far"]))
    if kind == "loop":
        (x, y), (a, b), turns = draw(point), draw(st.tuples(*[st.floats(2e-3, 0.15)] * 2)), draw(st.integers(1, 3))
        angle = np.linspace(0.0, 2.0 * math.pi, draw(st.integers(8, 200)))
        points = np.column_stack([x + a * np.cos(angle), y + b * np.sin(turns * angle)]).tolist()
    elif kind == "through":
        x, y = draw(st.floats(-0.05, 0.08)), draw(st.floats(0.1, 0.2))
        points = [[x, y], [draw(st.floats(-0.05, 0.08)), -y]]
    elif kind == "cusps":
        (x, y), side = draw(point), draw(st.floats(0.02, 0.1))
        points = [[x + side * (k % 2), y + 0.01 * k] for k in range(draw(st.integers(2, 6)))]
    elif kind == "far":
        points = [list(draw(point)), [1.0, draw(st.floats(-1.0, 1.0))], list(draw(point))]
    else:
        points = [list(one) for one in draw(st.lists(point, min_size=2, max_size=12))]
    body: dict[str, Any] = {"name": kind, "points": points, "smoothing": draw(st.sampled_from([0.0, 0.0, 0.003]))}
    seconds = draw(st.floats(3.0, 120.0))
    if draw(st.booleans()):
        gaps = np.array(draw(st.lists(st.floats(0.01, 1.0), min_size=len(points) - 1, max_size=len(points) - 1)))
        times = np.concatenate([[0.0], np.cumsum(gaps)]) * seconds / gaps.sum()
        return body | {"times": times.tolist(), "timing": {"kind": "given"}}
    timing = draw(
        st.sampled_from([{"kind": "fastest"}, {"kind": "speed", "speed": 0.3}, {"kind": "speed", "speed": 0.03}])
        | st.just({"kind": "duration", "duration": seconds})
    )
    return body | {"closed": draw(st.booleans()), "timing": timing}


def followed(leg: Leg, laps: int) -> tuple[Array, Array]:
    """Every row (n, 2) [m] that the rig takes of this leg, one by one as its tick does, and the torques."""
    rows, row = [], 0
    for _ in range(min(leg.ticks, len(leg.p) * (laps + 1))):
        rows.append(row)
        row = row + 1 if row + 1 < len(leg.p) else leg.again
    return leg.p[rows], leg.u[rows]


def beyond(p: Array, u: Array, rig: RigParameters, bounds: Settings = LIVE) -> list[str]:
    """What of these rows is beyond the limits, from rest to rest: written again, not the product's own function."""
    still = np.ones((T, 1))
    p, u = (np.concatenate([still * rows[:1], rows, still * rows[-1:]]) for rows in (p, u))
    speed = np.sqrt(((p[1:] - p[:-1]) ** 2).sum(axis=1)).max() / DT
    bend = np.sqrt(((p[2 * T :] - 2 * p[T:-T] + p[: -2 * T]) ** 2).sum(axis=1)).max() / (T * DT) ** 2
    rate = np.abs(u[1:] - u[:-1]).max() / DT
    smap = static_map(rig.actuator, rig.controller)
    off = np.sqrt(((static_tips(smap, u) - p) ** 2).sum(axis=1)).max()
    found = {
        f"{speed} m/s": speed > bounds.speed_max * TOLERANCE,
        f"{bend} m/s^2": bend > bounds.acceleration_max * TOLERANCE,
        f"{rate} N m/s": rate > TORQUE_RATE * TOLERANCE,
        f"{off} m off": off > 1.5e-4,
        "not admissible": ((u @ smap.polygon.normals.T) > smap.polygon.bounds * (1.0 + 1e-9)).any(),
    }
    return [text for text, bad in found.items() if bad]


def leg_of(body: Wanted, rig: RigParameters, laps: int, u: Array, bounds: Settings = LIVE) -> Leg:
    allowed = allowed_by(rig, bounds, drawn=body.drawing is not None)
    lap = lap_of(wanted(body, rig, bounds), rig, laps, allowed)
    return first_leg(static_map(rig.actuator, rig.controller), lap, laps, u)


REFUSED = r"the path takes [\d.]+ s, outside|rig's memory holds \d+ s|[\d.]+ m/s, more than 1 m/s|mm in all|all are one"
"""Why a drawing may be refused: what is too fast is slowed instead."""
EXAMPLES = 600 if os.environ.get("TENDRIL_LONG") else 12


@settings(max_examples=EXAMPLES, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True)
@given(bodies(), st.sampled_from(sorted(RIGS)), st.integers(1, 2), st.booleans(), st.floats(0.0, 1.0))
def test_what_is_drawn_or_imported_keeps_the_limits_or_is_refused_with_place_and_figure(
    body: dict[str, Any], name: str, laps: int, slow: bool, left: float
) -> None:
    rig, bounds = RIGS[name], Settings(speed_max=0.05, acceleration_max=0.4) if slow else LIVE
    smap = static_map(rig.actuator, rig.controller)
    try:
        drawing = Wanted(drawing=DrawingBody.model_validate(body))
        allowed = allowed_by(rig, bounds, drawn=True)
        lap = lap_of(wanted(drawing, rig, bounds), rig, laps, allowed)
        leg = first_leg(smap, lap, laps, np.array([0.02, -0.01]))
    except (ParameterError, ValidationError) as error:
        assert re.search(REFUSED, str(error)), error
        return
    assert beyond(*followed(leg, laps), rig, bounds) == []
    done = int(left * (lap.rows(laps) - 1))
    resumed = next_leg(smap, lap, laps, lap.torques[done % len(lap.p)], Place(done, lap.torques[done % len(lap.p)]))
    assert beyond(*followed(resumed, laps), rig, bounds) == []


@pytest.mark.parametrize("name", sorted(RIGS))
def test_through_the_hole_the_path_is_led_round_and_says_so(name: str) -> None:
    timing = {"kind": "speed", "speed": 0.05}
    body = DrawingBody.model_validate({"name": "through", "points": THROUGH, "timing": timing})
    found = drawing_plan(body, RIGS[name], LIVE)
    assert found.reachable and any(found.travel) and not all(found.travel)
    assert "detour of " in found.reason and "retimed from 6.4 s to " in found.reason
    assert found.peak_speed <= 0.2 and found.peak_acceleration <= 1.5
    leg = leg_of(Wanted(drawing=body), RIGS[name], 1, np.zeros(2))
    assert beyond(*followed(leg, 1), RIGS[name]) == []
    assert leg.travel[leg.again :].any(), "the way round is not judged"


def test_a_timed_file_that_jumps_is_slowed_there_and_keeps_its_pauses() -> None:
    p = np.array([[0.03, 0.14], [0.03, 0.14], [0.07, 0.14], [0.07, 0.14]])
    body = {"name": "steps", "points": p.tolist(), "times": [0.0, 2.0, 2.01, 5.0], "timing": {"kind": "given"}}
    leg = leg_of(Wanted(drawing=DrawingBody.model_validate(body)), RIGS["P1"], 1, np.zeros(2))
    assert beyond(*followed(leg, 1), RIGS["P1"]) == []
    shape = leg.p[leg.again :]
    moving = np.flatnonzero(np.linalg.norm(np.diff(shape, axis=0), axis=1) > 1e-6)
    assert 1.99 < moving[0] * DT < 2.3
    assert 5.0 < len(shape) * DT < 5.6


def test_the_noise_of_a_camera_does_not_slow_a_path() -> None:
    t = np.arange(0.0, 10.0, 0.01)
    rng = np.random.default_rng(4)
    p = np.column_stack([0.05 + 0.02 * np.cos(t), 0.14 + 0.02 * np.sin(t)]) + rng.normal(0.0, 1e-4, (len(t), 2))
    body = {"name": "seen", "points": p.tolist(), "times": t.tolist(), "timing": {"kind": "given"}}
    found = drawing_plan(DrawingBody.model_validate(body), RIGS["P1"], LIVE)
    assert found.duration == pytest.approx(9.99, abs=0.011)
    assert "retimed" not in found.reason
    leg = leg_of(Wanted(drawing=DrawingBody.model_validate(body)), RIGS["P1"], 1, np.zeros(2))
    assert beyond(*followed(leg, 1), RIGS["P1"]) == []


def test_the_fastest_ride_is_within_the_limits_after_all() -> None:
    cusp = [(0.03, 0.14), (0.07, 0.14), (0.031, 0.141)]
    for speed, acceleration in itertools.product((0.02, 0.2, 0.6), (0.1, 1.5, 8.0)):
        bounds = Settings(speed_max=speed, acceleration_max=acceleration)
        body = DrawingBody.model_validate({"name": "cusp", "points": cusp, "timing": {"kind": "fastest"}})
        leg = leg_of(Wanted(drawing=body), RIGS["P1"], 1, np.zeros(2), bounds)
        assert beyond(*followed(leg, 1), RIGS["P1"], bounds) == []


@pytest.mark.parametrize("name", [*sorted(PLANS), "live_path"])
def test_the_papers_references_are_followed_as_they_are_within_the_rigs_own_bounds(name: str) -> None:
    rig = RIGS["P1"]
    bounds = Settings(speed_max=1.0, acceleration_max=10.0)
    leg = leg_of(Wanted(reference=name), rig, 1, np.zeros(2))
    assert leg.steps == (name == "step")
    found = beyond(*followed(leg, 1), rig, bounds.model_copy(update={"acceleration_max": 25.0}))
    assert bool(found) == leg.steps
    assert beyond(leg.p[: leg.again - 3100 * leg.steps], leg.u[: leg.again - 3100 * leg.steps], rig) == []


def test_what_is_asked_beyond_the_rigs_memory_is_refused() -> None:
    slow = Settings(speed_max=0.001)
    body = {"name": "long", "points": THROUGH, "timing": {"kind": "speed", "speed": 0.05}}
    with pytest.raises(ParameterError, match=r"the path takes \d+ s, outside \[0.1, 280\] s"):
        partial(leg_of, Wanted(drawing=DrawingBody.model_validate(body)), RIGS["P1"], 1, np.zeros(2))(slow)


TURNS = np.linspace(0.0, 6.0 * math.pi, 600)
DRAWINGS: dict[str, dict[str, Any]] = {
    "through the hole": {
        "points": [(0.2, 0.1), (-0.05, 0.0), (0.2, -0.1)],
        "timing": {"kind": "duration", "duration": 8.0},
    },
    "along the hole": {"points": [(0.1, -0.2), (0.1, 0.2)], "timing": {"kind": "duration", "duration": 6.0}},
    "out of reach": {"points": [(0.4, 0.1), (0.4, -0.1), (-0.3, 0.0)], "timing": {"kind": "speed", "speed": 0.1}},
    "cusps": {
        "points": np.column_stack([0.12 - 0.02 * np.cos(TURNS), 0.0127 * (TURNS - np.sin(TURNS)) - 0.12]).tolist(),
        "timing": {"kind": "speed", "speed": 1.0},
    },
    "round the edge": {
        "points": [(-0.1, 0.16), (-0.17, 0.03), (-0.17, -0.06), (-0.12, -0.16)],
        "timing": {"kind": "duration", "duration": 20.0},
    },
}


@pytest.mark.parametrize(("rig", "name"), [*(("P1", name) for name in DRAWINGS), ("P2", "through the hole")])
def test_a_drawing_through_other_poses_is_planned_and_followed_to_its_end(rig: str, name: str) -> None:
    """On the twin, detours and the way back to the start included: there the arm once whipped, and broke off."""
    drawing = DrawingBody.model_validate({"name": name, **DRAWINGS[name]})
    found = predicted(PreviewBody(drawing=drawing, laps=2), RIGS[rig], LIVE, np.zeros(2))
    assert found.broken_off == ""
    assert found.max_error is not None and found.max_error < 0.05
