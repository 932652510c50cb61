"""A drawing of several strokes: travel between them within limits, left out of every figure; kept and read again."""

import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from controller.arrays import Rows
from controller.reference.feasible.bounds import accelerations, speeds, standing
from controller.reference.lettering import in_turn, strokes
from controller.schema.modes import Mode
from controller.schema.parameters import RigParameters, Settings
from controller.simulation.run import run
from server.drawing.messages import DrawingBody
from server.drawing.plan import drawing_plan
from server.drawing.planned import planned
from server.drawing.store import Drawings
from server.runs.laps import lap_of
from server.runs.messages import PreviewBody
from server.runs.preview import predicted
from tests.server.live_server import TestServer, taken, wait_for
from tests.server.run_world import settled
from tests.server.runs.test_runs import armed, lead, wait_run

RIG, LIVE, REST = RigParameters(), Settings(), np.zeros(2)
DT = RIG.controller.dt
BARS = [[(x, 0.13), (x, 0.15)] for x in (0.02, 0.035, 0.05)]
"""Three parallel strokes of 20 mm, each drawn upwards [m]."""


def piece(points: int, **more: Any) -> dict[str, Any]:
    return {"points": points, "centre": (0.0, 0.0), **more}


def bars(**more: Any) -> DrawingBody:
    body = {"name": "bars", "points": [p for bar in BARS for p in bar], "pieces": [piece(2) for _ in BARS]}
    return DrawingBody.model_validate(body | {"timing": {"kind": "speed", "speed": 0.02}} | more)


def test_the_tip_travels_between_strokes_within_the_limits_and_only_the_strokes_count() -> None:
    found, plan = planned(bars(), RIG, LIVE), drawing_plan(bars(), RIG, LIVE)
    assert found.travel is not None and found.travel[: found.start].all()
    p, travel = found.p[found.start :], found.travel[found.start :]
    edges = np.flatnonzero(np.diff(travel.astype(int)))
    parts, way = np.split(p, edges + 1), np.split(travel, edges + 1)
    assert [bool(part[0]) for part in way] == [False, True, False, True, False]
    for bar, drawn in zip(BARS, parts[::2], strict=True):
        assert drawn[[0, -1]] == pytest.approx(np.array(bar), abs=1e-4)
        assert len(drawn) == 1001, "20 mm at 20 mm/s"
    assert 0.04 < speeds(p, DT).max() <= LIVE.speed_max
    assert accelerations(standing(p, DT), DT).max() <= LIVE.acceleration_max
    assert plan.length == pytest.approx(0.06, rel=1e-6)
    assert plan.duration - plan.travel_duration == pytest.approx(3 * 1.001, abs=0.002)
    assert plan.peak_speed == pytest.approx(0.02, rel=1e-3), "that of the strokes"
    assert (plan.reason, plan.outside_share) == ("", 0.0)
    shown = np.array(plan.points)[np.array(plan.travel)]
    assert shown[:, 0].min() < 0.025 and shown[:, 0].max() > 0.045, "the page gets the way, and which it is"


def test_without_pieces_the_same_points_are_one_path_as_ever() -> None:
    plan = drawing_plan(bars(pieces=None), RIG, LIVE)
    assert not any(plan.travel) and plan.travel_duration == 0.0
    assert plan.length == pytest.approx(0.06 + 2 * np.hypot(0.015, 0.02), rel=5e-3), "corners lie between rows"


@pytest.mark.parametrize("timing", [{"kind": "duration", "duration": 6.0}, {"kind": "fastest"}])
def test_a_timing_is_that_of_the_strokes(timing: dict[str, Any]) -> None:
    plan = drawing_plan(bars(timing=timing), RIG, LIVE)
    drawn = plan.duration - plan.travel_duration
    alone = drawing_plan(bars(timing=timing, points=BARS[0], pieces=None), RIG, LIVE)
    assert plan.travel_duration > 0.2
    assert drawn == pytest.approx(6.0 if timing["kind"] == "duration" else 3 * alone.duration, abs=0.01)


def test_strokes_that_meet_are_one_and_a_closed_drawing_comes_back_to_its_beginning() -> None:
    corner = [(0.02, 0.13), (0.04, 0.13), (0.04, 0.13), (0.04, 0.15)]
    body = bars(points=corner, pieces=[piece(2), piece(2)])
    assert not any(drawing_plan(body, RIG, LIVE).travel)
    closed = drawing_plan(body.model_copy(update={"closed": True}), RIG, LIVE)
    assert closed.length == pytest.approx(0.04 + np.hypot(0.02, 0.02), rel=5e-3)
    apart = drawing_plan(bars(closed=True), RIG, LIVE)
    assert apart.length == pytest.approx(0.06 + np.hypot(0.03, 0.02), rel=5e-3)


def test_times_that_came_with_the_points_hold_for_the_way_between_pieces_too() -> None:
    times = np.arange(6.0).tolist()
    plan = drawing_plan(bars(times=times, timing={"kind": "given"}), RIG, LIVE)
    assert not any(plan.travel) and plan.duration == pytest.approx(5.0, abs=0.1)


def test_a_preview_counts_the_strokes_alone() -> None:
    found = predicted(PreviewBody(drawing=bars()), RIG, LIVE, REST)
    lap = lap_of(planned(bars(), RIG, LIVE), RIG, 1)
    rows = run(RIG, settled(planned(bars(), RIG, LIVE)), LIVE, RIG.twin.seed)[-len(lap.p) :]
    e = np.linalg.norm(lap.p - rows["p_meas"], axis=1)
    counted, whole = (float(np.sqrt(np.nanmean(part**2))) for part in (e[~lap.travel], e))
    assert found.rmse == pytest.approx(counted, rel=1e-6)
    assert abs(whole - counted) > 1e-4, "travel would have told"


def test_a_run_and_its_recording_count_the_strokes_alone(server: TestServer) -> None:
    batches: list[Rows] = []
    server.services.history.listen(batches.append)
    with armed(server) as (page, live):
        taken(page.run(json={"drawing": bars().model_dump(mode="json"), "laps": 1}))
        leg, led = server.services.runs._run._leg, lead(server)  # type: ignore[union-attr]
        wait_run(live, lambda state: state["state"] == "done")
        card = page.get("/api/runs").json()[0]
        kept = wait_for(lambda: page.get(f"/api/recordings/{card['recording']}").json()["metrics"], "the metrics")
    travelled = int(leg.travel.sum())
    assert travelled > led + 200, "the approach, and two ways between strokes"
    rows = np.concatenate(batches)
    tracked = rows[rows["mode"] == Mode.TRACK][: leg.ticks]
    e = (tracked["p_ref"] - tracked["p_meas"])[~leg.travel[leg.row(tracked["tick"] - tracked["tick"][0])]]
    e = e[np.isfinite(e).all(axis=1)]
    assert card["rmse"] == pytest.approx(np.sqrt(np.mean((e**2).sum(axis=1))), rel=1e-6)
    assert card["max_error"] == pytest.approx(np.linalg.norm(e, axis=1).max(), rel=1e-6)
    assert kept["approach"] == pytest.approx(DT * travelled, rel=1e-2)
    for name in ("rmse", "max_error"):
        assert kept[name] == pytest.approx(card[name], abs=1e-5), name


def test_saved_pieces_come_back_as_pieces(tmp_path: Path) -> None:
    store, laid = Drawings(tmp_path), [piece(2, group=1), piece(2, angle=0.5, scale=2.0, group=1), piece(2)]
    body = bars(pieces=laid)
    info = store.save(body)
    assert store.read("bars") == body
    assert (info.length, info.duration) == (pytest.approx(0.06), pytest.approx(3.0))


def test_a_drawing_without_pieces_is_kept_as_earlier_versions_read_it_and_later_ones_are_read(tmp_path: Path) -> None:
    store, file = Drawings(tmp_path), tmp_path / "bars.json"
    store.save(bars(pieces=None))
    said = json.loads(file.read_text())
    assert set(said) == {"name", "points", "closed", "smoothing", "timing", "outside"}
    file.write_text(json.dumps(said | {"times": None}))
    assert store.read("bars") == bars(pieces=None), "as earlier versions wrote it"
    later = said | {"colour": "red", "pieces": [piece(2, pressure=1.0) for _ in BARS]}
    file.write_text(json.dumps(later))
    assert store.read("bars") == bars()


def test_pieces_that_do_not_fit_their_points_are_refused() -> None:
    with pytest.raises(ValidationError, match="pieces have 4 points in all, but there are 6"):
        bars(pieces=[piece(2), piece(2)])
    with pytest.raises(ValidationError, match="scale"):
        bars(pieces=[piece(6, scale=0.0)])


def test_each_letter_s_stroke_begins_at_its_nearer_end() -> None:
    found = in_turn(strokes("HE", 0.03))
    assert len(found) == 7
    for before, after in pairwise(found):
        ends = np.linalg.norm(after[[0, -1]] - before[-1], axis=1)
        assert ends[0] <= ends[1]
