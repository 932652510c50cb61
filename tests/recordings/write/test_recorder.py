"""What the recorder writes is what rerun's own reader finds."""

import errno
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from rerun import RecordingStream

from controller.errors import RecordingError
from controller.schema.messages import Telemetry
from controller.schema.parameters import Settings
from recordings.format import sidecar, tool
from recordings.format.annotations import LogLine
from recordings.format.messages import Hole, Recording
from recordings.read.reader import read_about, read_log, read_rows
from recordings.store.store import Store
from recordings.write.rrd import RrdFile
from recordings.write.session import Context
from recordings.write.writer import Recorder
from tests.recordings.synthetic import batches, rig_info, telemetry_rows

pytestmark = pytest.mark.alone

Record = Callable[..., Recording]
SLOW = ("markers", "backbone", "twin_backbone")


def test_every_row_is_read_back_bit_for_bit(record: Record, tmp_path: Path) -> None:
    rows = telemetry_rows(3210)
    done = record(rows)
    found = read_rows(tmp_path / f"{done.id}.rrd")
    assert (done.rows, done.gaps, done.complete) == (3210, 0, True)
    for name in set(Telemetry.model_fields) - set(SLOW):
        assert found[name].dtype == rows[name].dtype, name
        np.testing.assert_array_equal(found[name], rows[name], err_msg=name)


def test_slots_that_the_rig_lost_show_as_steps_of_two(record: Record, tmp_path: Path) -> None:
    found = read_rows(tmp_path / f"{record(telemetry_rows(3210)).id}.rrd")
    assert np.flatnonzero(np.diff(found["slot"]) == 2).tolist() == [1499, 2999]
    assert (np.diff(found["tick"]) == 1).all()


def test_markers_and_backbones_are_exact_at_the_ticks_they_name(record: Record, tmp_path: Path) -> None:
    rows = telemetry_rows(1005)
    found = read_rows(tmp_path / f"{record(rows).id}.rrd")
    for name in SLOW:
        ticks = found[f"{name}_tick"]
        assert ticks.tolist() == list(range(0, 1005, 10))
        np.testing.assert_array_equal(found[name], rows[name][ticks], err_msg=name)


def test_a_backbone_that_is_not_known_is_not_recorded(record: Record, tmp_path: Path) -> None:
    rows = telemetry_rows(100)
    rows["twin_backbone"] = np.nan
    found = read_rows(tmp_path / f"{record(rows).id}.rrd")
    assert len(found["twin_backbone"]) == 0
    assert len(found["backbone"]) == 10


def test_a_stopped_recording_passes_reruns_own_check(record: Record, tmp_path: Path) -> None:
    tool.run("rrd", "verify", str(tmp_path / f"{record(telemetry_rows(1000)).id}.rrd"), timeout=60)


def test_ticks_that_were_not_delivered_are_counted_and_logged(record: Record, tmp_path: Path) -> None:
    done = record(np.delete(telemetry_rows(1000), slice(400, 407)))
    assert (done.rows, done.gaps) == (993, 7)
    assert any("7 ticks" in text for _, level, text in read_log(tmp_path / f"{done.id}.rrd") if level == "WARN")


def test_a_restart_of_the_rig_is_logged_and_is_no_gap(record: Record, tmp_path: Path) -> None:
    before, after = telemetry_rows(500, first=4000), telemetry_rows(500)
    after["t_ns"] += before["t_ns"][-1] - after["t_ns"][0] + 3_000_000_000
    done = record(np.concatenate([before, after]))
    assert (done.rows, done.gaps) == (1000, 0)
    assert any("restarted" in text for _, _, text in read_log(tmp_path / f"{done.id}.rrd"))


def test_mode_changes_and_events_are_in_the_log_at_their_ticks(recorder: Recorder, tmp_path: Path) -> None:
    rows = telemetry_rows(1200)
    id = recorder.start("log", rig_info(), Settings()).id
    recorder.rows(rows[:900])
    recorder.annotate(LogLine("operator: K_P 0.4 -> 0.5"))
    recorder.rows(rows[900:])
    recorder.stop()
    assert read_log(tmp_path / f"{id}.rrd") == [
        (0, "INFO", "0.00 s  VENTED (start)"),
        (300, "INFO", "0.30 s  HOLD (operator)"),
        (800, "INFO", "0.80 s  FOLLOW (operator)"),
        (899, "INFO", "0.90 s  operator: K_P 0.4 -> 0.5"),
    ]


def test_a_recording_says_who_recorded_it_and_with_which_parameters(record: Record, tmp_path: Path) -> None:
    done = record(telemetry_rows(10))
    assert read_about(tmp_path / f"{done.id}.rrd") == (rig_info(), Settings())
    assert Store(tmp_path).list() == [done]
    assert (done.name, done.actuator, done.twin) == ("Circle, 0.5 Hz", "P1", True)


def test_a_recording_without_rows_is_whole(record: Record, tmp_path: Path) -> None:
    done = record(telemetry_rows(0))
    assert (done.rows, done.seconds, done.complete) == (0, 0.0, True)
    assert len(read_rows(tmp_path / f"{done.id}.rrd")["tick"]) == 0


def test_two_recordings_at_once_are_refused(recorder: Recorder) -> None:
    with pytest.raises(RecordingError, match="no recording is running"):
        recorder.stop()
    state = recorder.start("first", rig_info(), Settings())
    with pytest.raises(RecordingError, match=state.id):
        recorder.start("second", rig_info(), Settings())
    assert recorder.stop().rows == 0


def test_a_folder_that_is_gone_is_made_again_and_one_that_cannot_be_is_named(tmp_path: Path) -> None:
    folder = tmp_path / "runs"
    folder.mkdir()
    recorder = Recorder(folder)
    folder.rmdir()
    recorder.start("made again", rig_info(), Settings())
    assert recorder.stop().complete
    folder.rename(tmp_path / "elsewhere")
    folder.write_text("a file in its place")
    with pytest.raises(RecordingError, match="runs"):
        recorder.start("no place", rig_info(), Settings())
    recorder.close()


@pytest.mark.parametrize("failing", ["flush", "description"])
def test_a_start_that_fails_leaves_nothing_and_holds_no_lock(
    recorder: Recorder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, failing: str
) -> None:
    with monkeypatch.context() as full:
        if failing == "flush":
            full.setattr(RrdFile, "flush", _full)
        else:
            full.setattr(sidecar, "_put", _no_space)
        with pytest.raises(RecordingError, match="no room"):
            recorder.start("full", rig_info(), Settings())
    left = [path.name for path in tmp_path.iterdir() if path.name != sidecar.TURN]
    assert left == [] and Store(tmp_path).list() == []
    recorder.start("with room again", rig_info(), Settings())
    assert recorder.stop().complete


def test_rows_may_be_overwritten_once_handed_over(recorder: Recorder, tmp_path: Path) -> None:
    rows = telemetry_rows(50)
    recorder.start("reused buffer", rig_info(), Settings())
    buffer = rows.copy()
    recorder.rows(buffer)
    buffer["tick"] = -1
    assert read_rows(tmp_path / f"{recorder.stop().id}.rrd")["tick"].tolist() == list(range(50))


def test_the_last_ten_seconds_before_the_button_are_in_the_file(recorder: Recorder, tmp_path: Path) -> None:
    rows = telemetry_rows(13_000)
    for batch in batches(rows[:12_345]):
        recorder.rows(batch)
    id = recorder.start("began before", rig_info(), Settings()).id
    recorder.rows(rows[12_345:])
    done = recorder.stop()
    found = read_rows(tmp_path / f"{id}.rrd")
    assert found["tick"].tolist() == list(range(2_345, 13_000))
    np.testing.assert_array_equal(found["p_meas"], rows["p_meas"][2_345:])
    assert (done.gaps, done.holes) == (0, ())


def test_rows_of_the_rigs_life_before_are_not_what_came_before_the_button(recorder: Recorder, tmp_path: Path) -> None:
    recorder.rows(telemetry_rows(500, first=4000))
    recorder.rows(telemetry_rows(20))
    recorder.start("new boot", rig_info(), Settings())
    assert read_rows(tmp_path / f"{recorder.stop().id}.rrd")["tick"].tolist() == list(range(20))


def test_a_recording_that_goes_on_begins_after_the_last_tick_of_the_one_before(
    recorder: Recorder, tmp_path: Path
) -> None:
    rows = telemetry_rows(400)
    recorder.rows(rows[200:300])
    whole = Context(part_of="20260101-000000-first", earlier=rows[100:250], after=99)
    recorder.start("goes on", rig_info(), Settings(), whole)
    recorder.rows(rows[300:])
    done = recorder.stop()
    assert read_rows(tmp_path / f"{done.id}.rrd")["tick"].tolist() == list(range(100, 400))
    assert (done.gaps, done.part_of) == (0, "20260101-000000-first")


def test_what_the_ring_no_longer_held_is_a_hole_of_the_recording_that_goes_on(recorder: Recorder) -> None:
    recorder.start("torn", rig_info(), Settings(), Context(earlier=telemetry_rows(50, first=150), after=99))
    assert recorder.stop().holes == (Hole(after=99, ticks=50),)


def test_a_full_disk_ends_the_recording_says_so_and_leaves_it_readable(tmp_path: Path) -> None:
    program = [sys.executable, "-m", "tests.recordings.write_until_full", str(tmp_path)]
    done = subprocess.run(program, capture_output=True, text=True, timeout=200, check=True)
    assert "the recording ended by itself" in done.stdout
    [left] = Store(tmp_path).list()
    assert not left.complete
    found = read_rows(tmp_path / f"{left.id}.rrd")["tick"]
    assert len(found) > 100
    assert (found == np.arange(len(found))).all()


def test_who_hears_that_it_ended_by_itself_finds_all_its_rows_in_the_list(
    recorder: Recorder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    abandon = RrdFile.abandon

    def slowly(file: RrdFile) -> None:
        time.sleep(0.3)
        abandon(file)

    recorder.start("full", rig_info(), Settings(), Context(earlier=telemetry_rows(500)))
    monkeypatch.setattr(RrdFile, "abandon", slowly)
    monkeypatch.setattr(RrdFile, "write", _full)
    recorder.rows(telemetry_rows(500, first=500))
    end = time.monotonic() + 60.0
    while recorder.state().recording and time.monotonic() < end:
        time.sleep(0.005)
    assert "no room" in recorder.state().problem
    [left] = Store(tmp_path).list()
    assert left.rows == 500 and not left.complete


def test_a_file_that_grows_no_more_ends_the_recording_though_rerun_reports_nothing(
    recorder: Recorder, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As with one full disk in fifteen: rerun's writer is dead, and its flush succeeds. Here it is given nothing."""
    recorder.start("full", rig_info(), Settings())
    monkeypatch.setattr(RrdFile, "write", lambda file, rows: None)
    given = iter(batches(telemetry_rows(60_000)))
    end = time.monotonic() + 60.0
    while recorder.state().recording and time.monotonic() < end:
        recorder.rows(next(given))
        time.sleep(0.01)
    assert "grows no more" in recorder.state().problem


def test_a_file_that_takes_no_footer_is_not_complete(recorder: Recorder, monkeypatch: pytest.MonkeyPatch) -> None:
    """As where rerun's writer dies within the last second, and its flush succeeds."""
    recorder.start("full", rig_info(), Settings())
    recorder.rows(telemetry_rows(100))
    monkeypatch.setattr(RecordingStream, "disconnect", lambda stream: None)
    with pytest.raises(RecordingError, match="grew no more at its end"):
        recorder.stop()
    assert "grew no more at its end" in recorder.state().problem


def test_a_file_that_failed_and_never_closes_stops_no_other(
    recorder: Recorder, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rerun's disconnect may wait for ever for the writer of a full disk; here it waits for the test."""
    over, closed = threading.Event(), threading.Event()

    def wait_for_ever(_: RecordingStream) -> None:
        over.wait(30.0)
        closed.set()

    recorder.start("full", rig_info(), Settings())
    with monkeypatch.context() as full:
        full.setattr(RrdFile, "write", _full)
        full.setattr(RecordingStream, "disconnect", wait_for_ever)
        recorder.rows(telemetry_rows(2000))
        with pytest.raises(RecordingError, match="ended by itself: no room"):
            recorder.stop()
    recorder.start("with room again", rig_info(), Settings())
    recorder.rows(telemetry_rows(100))
    assert recorder.stop().complete
    assert not closed.is_set(), "no one waited for it"
    over.set()


def _no_space(*_: object) -> None:
    raise OSError(errno.ENOSPC, "no room")


def _full(*_: object) -> None:
    raise RecordingError("no room")
