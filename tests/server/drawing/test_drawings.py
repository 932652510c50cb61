"""Drawn references: planned, foreseen, kept, and asked for over REST."""

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from controller.assembly.statics import static_map
from controller.errors import ParameterError
from controller.reference.feasible.approach import branch
from controller.reference.feasible.reach import static_tips
from controller.reference.path_file import read_samples
from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.schema.modes import Mode
from controller.schema.parameters import RigParameters, Settings
from controller.simulation.metrics import rmse
from controller.simulation.run import run
from server.drawing.errors import UnknownDrawing
from server.drawing.messages import DrawingBody
from server.drawing.plan import csv_of, drawing_plan
from server.drawing.planned import planned
from server.drawing.store import Drawings
from server.operate.settings import FIRST
from server.runs.laps import SETTLE
from server.runs.messages import PreviewBody
from server.runs.preview import predicted
from server.runs.tracker import standing
from tests.server.live_server import TestServer, wait_for
from tests.server.run_world import settled

RIG, LIVE, REST = RigParameters(), Settings(), np.zeros(2)
STAR = [(0.03 + 0.02 * math.sin(turn), 0.14 + 0.02 * math.cos(turn)) for turn in 0.8 * math.pi * np.arange(5)]
SLOW = {"kind": "speed", "speed": 0.02}
SQUARE = [(0.02, 0.13), (0.04, 0.13), (0.04, 0.15), (0.02, 0.15)]


def drawing(**more: Any) -> DrawingBody:
    return DrawingBody.model_validate({"name": "star", "points": STAR, "closed": True, "timing": SLOW, **more})


def error(rig: RigParameters) -> float:
    """RMSE [m] of the measured tip after the approach, on the twin of `rig`, of the star as `RIG` plans it."""
    reference = settled(planned(drawing(), RIG, LIVE))
    rows = run(rig, reference, LIVE, rig.twin.seed)
    return rmse((reference.p - rows["p_meas"])[reference.start :])


def test_a_square_is_as_long_and_as_fast_as_asked() -> None:
    found = drawing_plan(drawing(points=SQUARE), RIG, LIVE)
    assert found.length == pytest.approx(0.08)
    assert found.duration == pytest.approx(4.0)
    assert found.approach > 2.0, "at 200 mm/s the arm takes longer to its first point"
    assert found.peak_speed == pytest.approx(0.02, rel=1e-3)
    assert found.peak_acceleration == pytest.approx(math.sqrt(2.0) * 0.02 / 0.02, rel=0.02), "a right angle in 20 ms"
    assert (found.reachable, found.reason, found.outside_share) == (True, "", 0.0)
    assert found.points[0] == found.points[-1] == found.wished[0] == SQUARE[0]
    assert len(found.t) == len(found.points) == len(found.wished) == len(found.inside) == 2000


def test_the_fastest_ride_follows_the_settings_in_force() -> None:
    tight = Settings(speed_max=0.05, acceleration_max=0.2)
    found = drawing_plan(drawing(timing={"kind": "fastest"}), RIG, tight)
    assert 0.04 < found.peak_speed <= 0.05 * (1.0 + 1e-6)
    assert found.peak_acceleration <= 0.2 * 1.02
    assert found.duration > drawing_plan(drawing(timing={"kind": "fastest"}), RIG, LIVE).duration


def test_given_times_are_kept_also_where_the_path_is_smoothed() -> None:
    times = [5.0, 6.0, 8.0, 9.0]
    for smoothing in (0.0, 1e-3):
        body = drawing(points=SQUARE, closed=False, times=times, timing={"kind": "given"}, smoothing=smoothing)
        found = planned(body, RIG, LIVE)
        assert len(found.p) - found.start == 4001
        for t, corner in zip(times, SQUARE, strict=True):
            assert np.linalg.norm(found.p[found.start + round(1e3 * (t - 5.0))] - corner) <= smoothing + 1e-9


def test_what_leaves_the_reach_is_projected_or_refused_as_asked() -> None:
    far = [(x, y + 0.1) for x, y in STAR]
    found = drawing_plan(drawing(points=far), RIG, LIVE)
    assert 0.0 < found.outside_share < 1.0
    assert found.reachable
    assert "out of reach" in found.reason
    wished, points, inside = np.array(found.wished), np.array(found.points), np.array(found.inside)
    assert wished[inside] == pytest.approx(points[inside], abs=1e-4)
    assert (np.linalg.norm(wished - points, axis=1)[~inside] > 5e-5).all()
    assert not drawing_plan(drawing(points=far, outside="refuse"), RIG, LIVE).reachable
    with pytest.raises(ParameterError, match=r"outside = refuse: star: .* out of reach"):
        planned(drawing(points=far, outside="refuse"), RIG, LIVE)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (
            {"timing": {"kind": "speed", "speed": 1e-3}, "points": [(0, 0.1), (1, 0.1)]},
            r"speed = 0.001 .* 2000 s.* 280",
        ),
        ({"timing": {"kind": "duration", "duration": 0.1}}, r"duration = 0.1 s: 1.9 m/s, more than 1 m/s"),
        ({"points": [(0.1, 0.1), (0.1, 0.1)]}, r"points: 0 mm .* less than 1 mm"),
        ({"times": [0, 1, 2, 3, 900], "timing": {"kind": "given"}, "closed": False}, r"times: .* 900 s"),
    ],
)
def test_what_cannot_be_timed_is_refused_with_value_and_bound(change: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ParameterError, match=complaint):
        planned(drawing(**change), RIG, LIVE)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"times": [0.0, 1.0]}, "2 values, but there are 5 points"),
        ({"times": [0.0, 2.0, 1.0, 3.0, 4.0]}, "1 s is not after 2 s"),
        ({"timing": {"kind": "given"}, "closed": False}, "no times"),
        ({"name": "a.csv"}, "download"),
        *(
            ({"name": name}, "string_pattern_mismatch")
            for name in ("../star", "a/b", ".hidden", " a", "a ", "a\nb", "a\\b")
        ),
    ],
)
def test_a_drawing_that_is_none_is_refused(change: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValidationError, match=complaint):
        drawing(**change)


def test_the_preview_is_what_the_twin_does() -> None:
    found = predicted(PreviewBody(drawing=drawing()), RIG, LIVE, REST)
    assert found.broken_off == ""
    assert found.rmse == pytest.approx(error(RIG), rel=1e-9)
    assert found.t[found.start] == pytest.approx(settled(planned(drawing(), RIG, LIVE)).start * 1e-3, abs=0.01)
    rest = static_tips(static_map(RIG.actuator, RIG.controller), REST)
    assert found.approach[0] == pytest.approx(tuple(rest.ravel()), abs=1e-4)
    assert found.approach[-1] == pytest.approx(STAR[0], abs=1e-4)
    assert found.rmse < (found.max_error or 0.0) < 0.03
    twice, begin = predicted(PreviewBody(drawing=drawing(), laps=2), RIG, LIVE, REST), found.t[found.start]
    assert twice.t[-1] - begin == pytest.approx(2.0 * (found.t[-1] - begin), rel=1e-3)


def test_the_preview_begins_where_the_rig_stands() -> None:
    smap = static_map(RIG.actuator, RIG.controller)
    row = np.zeros(1, record_dtype(Telemetry))
    row["u_ff"] = branch(smap, np.array(STAR[:1]))
    assert standing(None) == pytest.approx(REST)
    assert standing(row) == pytest.approx(REST), "vented"
    row["mode"] = Mode.HOLD
    assert static_tips(smap, standing(row)) == pytest.approx(STAR[0], abs=1e-4)
    near = branch(smap, np.array([[STAR[0][0], STAR[0][1] - 2e-3]]))
    here, beside, rest = (predicted(PreviewBody(drawing=drawing()), RIG, LIVE, u) for u in (standing(row), near, REST))
    assert here.points[0] == pytest.approx(STAR[0], abs=5e-3)
    assert here.t[here.start] == pytest.approx(0.1, abs=0.01), "it stands at the first point: no approach"
    assert beside.t[beside.start] == pytest.approx(2.0 + SETTLE, abs=0.01), "the least time of an approach"
    assert beside.approach[0] == pytest.approx((STAR[0][0], STAR[0][1] - 2e-3), abs=1e-4), "from where it stands"
    assert here.t[-1] - here.t[here.start] == pytest.approx(rest.t[-1] - rest.t[rest.start], abs=0.02)
    assert here.rmse == pytest.approx(rest.rmse, rel=0.1), "there is no swing left from either approach"


def test_the_prediction_holds_on_a_plant_that_is_stiffer_and_later() -> None:
    """Bar: within 15 % on the nominal twin, whatever its noise, and 40 % where it is 10 % stiffer and 10 ms later."""
    foreseen = predicted(PreviewBody(drawing=drawing()), RIG, LIVE, REST).rmse
    nominal = RIG.twin.model_copy(update={"seed": 7})
    later = {"stiffness_scale": 1.1, "dead_time": RIG.twin.dead_time + 0.01}
    assert error(RIG.model_copy(update={"twin": nominal})) == pytest.approx(foreseen, rel=0.15)
    assert error(RIG.model_copy(update={"twin": nominal.model_copy(update=later)})) == pytest.approx(foreseen, rel=0.40)


def test_a_run_that_would_be_broken_off_says_when_and_why() -> None:
    wild = LIVE.model_copy(update={"K_P": (5.0, 5.0), "K_I": (20.0, 20.0)})
    found = predicted(PreviewBody(reference="circle_1hz", laps=3), RIG, wild, REST)
    assert re.fullmatch(
        r"Circle, 1 Hz: (REST|FAULT|E_STOP) \(\w+\) after \d+\.\d+ s, instead of to the end", found.broken_off
    )
    assert (found.rmse, found.max_error, found.lag_deg_x) == (None, None, None)
    assert found.t[-1] < 23.0
    assert any(found.saturated)


def test_the_csv_is_what_would_be_followed(tmp_path: Path) -> None:
    file = tmp_path / "star.csv"
    file.write_text(csv_of(drawing(), RIG, LIVE))
    samples, reference = read_samples(file), planned(drawing(), RIG, LIVE)
    assert samples.t[-1] == pytest.approx((len(reference.p) - 1 - reference.start) * 1e-3)
    assert samples.p == pytest.approx(reference.p[reference.start :], abs=1e-7)


def test_drawings_are_kept_by_name_and_damaged_ones_do_no_harm(tmp_path: Path) -> None:
    store = Drawings(tmp_path / "drawings")
    assert store.listed() == []
    info = store.save(drawing())
    assert (info.name, info.points) == ("star", 5)
    assert info.duration == pytest.approx(info.length / 0.02)
    assert store.read("star") == drawing()
    store.save(drawing(name="second try", timing={"kind": "fastest"}))
    (tmp_path / "drawings" / "bad.json").write_text('{"name": "bad"')
    (tmp_path / "drawings" / "copy of star.json").write_text(drawing().model_dump_json())
    assert {info.name for info in store.listed()} == {"star", "second try", "copy of star"}
    with pytest.raises(UnknownDrawing, match="damaged"):
        store.read("bad")
    store.delete("bad")
    with pytest.raises(UnknownDrawing, match="there is no drawing 'bad'"):
        store.delete("bad")


@pytest.mark.parametrize("name", ["../secrets", "/etc/passwd", "..", "", "a" * 81, "a\0b"])
def test_no_name_leads_out_of_the_folder(tmp_path: Path, name: str) -> None:
    (tmp_path / "secrets.json").write_text(drawing().model_dump_json())
    store = Drawings(tmp_path / "drawings")
    for attempt in (store.read, store.delete):
        with pytest.raises(UnknownDrawing):
            attempt(name)
    assert (tmp_path / "secrets.json").exists()


def test_a_page_plans_foresees_saves_and_deletes(server: TestServer) -> None:
    page, viewer = server.page().sign_in().operate(), server.page().sign_in()
    wait_for(lambda: viewer.get("/api/rig").status_code == 200, "the rig")
    body = drawing().model_dump(mode="json")

    assert viewer.post("/api/drawings/plan", json=body).json()["reachable"]
    preview = viewer.post("/api/preview", json={"drawing": body}).json()
    assert preview["rmse"] == pytest.approx(
        predicted(PreviewBody(drawing=drawing()), RIG, LIVE.model_copy(update=FIRST), REST).rmse
    )
    assert viewer.post("/api/drawings/text", json={"text": "VU", "height": 0.02}).json()["points"][0] == [0.00095, 0.02]

    assert viewer.put("/api/drawings/star", json=body).status_code == 403
    assert viewer.delete("/api/drawings/star").status_code == 403
    assert page.put("/api/drawings/star", json=body).json()["name"] == "star"
    assert [info["name"] for info in viewer.get("/api/drawings").json()] == ["star"]
    assert viewer.get("/api/drawings/star").json() == body
    file = viewer.get("/api/drawings/star.csv")
    assert file.headers["content-disposition"] == 'attachment; filename="star.csv"'
    assert file.text.startswith("t_s,x_m,y_m\n0.0000,")
    assert page.delete("/api/drawings/star").status_code == 204
    for gone in ("star", "star.csv"):
        assert viewer.get(f"/api/drawings/{gone}").status_code == 404


def test_a_page_is_told_field_value_and_bound(server: TestServer) -> None:
    page = server.page().sign_in()
    wait_for(lambda: page.get("/api/rig").status_code == 200, "the rig")
    body = drawing().model_dump(mode="json")
    refused = page.post("/api/drawings/plan", json=body | {"smoothing": 0.5})
    (complaint,) = refused.json()["detail"]
    assert (refused.status_code, complaint["loc"], complaint["input"]) == (422, ["body", "smoothing"], 0.5)
    assert complaint["ctx"] == {"le": 0.02}
    short = page.post("/api/preview", json={"drawing": body | {"timing": {"kind": "duration", "duration": 0.1}}})
    assert (short.status_code, short.json()["detail"][:25]) == (422, "timing.duration = 0.1 s: ")
    assert page.post("/api/preview", json={}).status_code == 422
    assert page.post("/api/preview", json={"reference": "nonsense"}).status_code == 404
    assert page.post("/api/drawings/text", json={"text": "\u03b1", "height": 0.02}).status_code == 422
    assert page.get("/api/drawings/..%2Fsecrets").status_code in (404, 422)
