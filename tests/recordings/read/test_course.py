"""What a recording says of its own course: what was before the run, approaches, pauses, and the run's clock."""

import json
import re
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest

from controller.schema.modes import Mode
from controller.schema.parameters import Settings
from recordings.format import sidecar
from recordings.format.annotations import Approach
from recordings.read.course import at_run_clock, run_clock, stretches
from recordings.read.quick import quick_look
from recordings.read.reader import read_rows, read_start
from recordings.store.comparing import apart, run_tip
from recordings.store.finishing import depict, finish
from recordings.store.store import Store
from recordings.write.session import Context
from recordings.write.writer import Recorder
from tests.recordings.synthetic import batches, rig_info, telemetry_rows

pytestmark = pytest.mark.keyed()

ROWS_S = 1e-3


def course_of(text: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, modes and approach notes of a second a letter: h holds, a approaches, t tracks, f follows."""
    letters = np.repeat(list(text), 1000)
    modes = {"h": Mode.HOLD, "a": Mode.TRACK, "t": Mode.TRACK, "f": Mode.FOLLOW}
    return np.arange(len(letters)) * ROWS_S, np.array([modes[letter] for letter in letters]), letters == "a"


@pytest.mark.parametrize(
    "text, expected",
    [
        ("hhhaatttth", "before 0-3, approach 3-5, run 5-9, after 9-10"),
        ("haatthhatt", "before 0-1, approach 1-3, run 3-5, pause 5-7, approach 7-8, run 8-10"),
        ("ttthhaattt", "before 0-5, approach 5-7, run 7-10"),  # the end of a run before
        ("aatttttttt", "approach 0-2, run 2-10"),
    ],
)
def test_a_run_is_told_from_what_is_before_between_and_after(text: str, expected: str) -> None:
    t, mode, approach = course_of(text)
    found = stretches(t, mode, approach, begun=2.0)
    assert ", ".join(f"{part.kind} {part.start:.0f}-{part.end:.0f}" for part in found) == expected


def test_without_a_run_it_is_what_came_since_the_recording_was_begun() -> None:
    t, mode, _ = course_of("hhhfffffhh")
    found = stretches(t, mode, None, begun=2.5)
    assert [(part.kind, part.start) for part in found] == [("before", 0.0), ("run", 2.5)]
    assert [part.kind for part in stretches(t, mode, None, begun=0.0)] == ["run"]
    earlier = stretches(t, np.where(t < 2.0, Mode.TRACK, Mode.FOLLOW), None, begun=3.0)
    assert [(part.kind, part.start) for part in earlier] == [("before", 0.0), ("run", 3.0)], "an earlier run is none"
    assert stretches(t[:0], mode[:0], None, 0.0) == []


def test_the_runs_clock_stands_still_in_a_pause_and_leads_back_to_the_time_in_the_file() -> None:
    t, mode, approach = course_of("haatthhatt")
    parts = stretches(t, mode, approach, 0.0)
    clock = run_clock(t, parts)
    assert np.isfinite(clock).sum() == 4000
    known = clock[np.isfinite(clock)]
    np.testing.assert_allclose(known, np.arange(4000) * ROWS_S, atol=1e-9)
    assert at_run_clock(0.5, parts) == pytest.approx(3.5)
    assert at_run_clock(2.5, parts) == pytest.approx(8.5)


def recorded_run(folder: Path, before: float, pause: tuple[float, float] | None, name: str) -> str:
    """A circle of 0.5 Hz for 12 s after `before` seconds of HOLD and 2 s of approach; held at and for `pause` [s]."""
    legs = [12.0] if pause is None else [pause[0], 12.0 - pause[0]]
    rests = [before, *([pause[1]] if pause else [])]
    run = telemetry_rows(12_000)
    parts, modes, leads, at = [], [], [], 0
    for rest, leg in zip(rests, legs, strict=True):
        count, still = round(leg * 1e3), telemetry_rows(round((rest + 2.0) * 1e3))
        still["p_ref"], still["p_meas"] = run["p_ref"][at], (0.2, 0.0)
        parts += [still, run[at : at + count]]
        modes += [np.where(np.arange(len(still)) < rest * 1e3, Mode.HOLD, Mode.TRACK), np.full(count, Mode.TRACK)]
        leads.append(sum(map(len, parts[:-2])) + round(rest * 1e3))
        at += count
    rows = telemetry_rows(sum(map(len, parts)))
    for field in ("p_ref", "p_meas"):
        rows[field] = np.concatenate([part[field] for part in parts])
    rows["mode"] = np.concatenate(modes)
    recorder = Recorder(folder)
    recorder.start(name, rig_info(), Settings(), Context(profile="standard"))
    for batch in batches(rows, 500):
        recorder.rows(batch)
    for lead in leads:
        recorder.annotate(Approach(int(rows["tick"][lead]), int(rows["tick"][lead]) + 2000))
    id = recorder.stop().id
    recorder.close()
    return id


def test_two_runs_of_one_path_are_one_line_whatever_was_before_them_and_between(tmp_path: Path) -> None:
    ids = [recorded_run(tmp_path, 3.0, None, "plain"), recorded_run(tmp_path, 7.0, (5.3, 4.0), "paused")]
    paths = [Store(tmp_path).path(id) for id in ids]
    looks = [json.loads(quick_look(path, 2000)) for path in paths]
    starts = [part["start"] for look in looks for part in look["stretches"] if part["kind"] == "run"]
    assert starts == pytest.approx([5.0, 9.0, 20.3], abs=0.02)
    tips = [run_tip(read_rows(path, ("p_meas", "mode"))) for path in paths]
    assert apart(*tips)["apart_max"] < 2e-3, "lost slots alone part them"
    assert looks[0]["period"] == pytest.approx(2.0, rel=2e-3)
    assert looks[1]["period"] == pytest.approx(2.0, rel=2e-3), "a pause does not hide that it repeats"


def test_a_recording_is_known_to_have_begun_after_the_rows_that_were_in_memory(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path)
    id = recorder.start("drag", rig_info(), Settings()).id
    for batch in batches(telemetry_rows(8000), 500):
        recorder.rows(batch)
    recorder.stop()
    recorder.close()
    path = Store(tmp_path).path(id)
    first = sidecar.read(tmp_path, id)
    wall = first.started.fromtimestamp(read_start(path) * 1e-9, first.started.tzinfo)
    sidecar.write(tmp_path, first.model_copy(update={"started": wall + timedelta(seconds=5)}))
    look = json.loads(quick_look(path, 400))
    assert [(part["kind"], round(part["start"], 3)) for part in look["stretches"]] == [("before", 0.0), ("run", 5.0)]


@pytest.mark.process
def test_a_picture_is_the_path_of_the_last_lap_in_a_few_hundred_bytes(tmp_path: Path) -> None:
    id = recorded_run(tmp_path, 3.0, (5.3, 2.0), "paused")
    assert finish(tmp_path, id) == ()
    picture = sidecar.read(tmp_path, id).thumbnail
    assert picture is not None and 100 < len(picture) < 500
    numbers = [[float(n) for n in part.split()] for part in re.split("[Ml]", picture)[1:]]
    points = np.cumsum(np.array(numbers[0] + numbers[1]).reshape(-1, 2), axis=0)
    np.testing.assert_allclose(np.hypot(*(points - 50.0).T), 50.0, atol=1.5)
    sidecar.update(tmp_path, id, thumbnail=None)
    depict(tmp_path, id)
    assert sidecar.read(tmp_path, id).thumbnail == picture


def test_a_tip_at_rest_is_a_dot_and_one_never_seen_is_no_picture(tmp_path: Path) -> None:
    rows = telemetry_rows(3000)
    for value in (0.1, np.nan):
        rows["p_meas"] = value
        recorder = Recorder(tmp_path)
        id = recorder.start("still", rig_info(), Settings()).id
        recorder.rows(rows)
        recorder.stop()
        recorder.close()
        depict(tmp_path, id)
        assert sidecar.read(tmp_path, id).thumbnail == ("M50 50" if np.isfinite(value) else "")
