"""What a file holds besides its rows, and what it leaves behind in the process that wrote it."""

import os
import subprocess
import sys
import threading
from concurrent.futures import wait
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest
import rerun as rr
from rerun.chunk import RrdReader

from controller.errors import RecordingError
from controller.schema.parameters import Settings
from controller.system.thread import in_thread
from recordings.format.about import About
from recordings.write import rrd
from recordings.write.rrd import RrdFile
from tests.recordings.synthetic import rig_info, telemetry_rows

GROWTH_MAX_MB = 0.5
"""Per file, beyond what the first ten need: rerun kept 2.8 MB of each when the layout was given to `save`."""


@pytest.mark.parametrize("rows", [0, 3])
@pytest.mark.parametrize("flushed", [False, True])
def test_the_layout_is_in_the_smallest_file(tmp_path: Path, rows: int, flushed: bool) -> None:
    for k in range(10):  # rerun reads the layout apart: a file closed at once must hold it nevertheless
        file = RrdFile(tmp_path / f"{k}.rrd", About(f"{k}", "name", rig_info(), Settings(), "full"))
        if rows:
            file.write(telemetry_rows(rows))
        if flushed:
            file.flush()
        file.close()
        found = RrdReader(tmp_path / f"{k}.rrd")
        assert [entry.recording_id for entry in found.recordings()] == [f"{k}"]
        assert [entry.application_id for entry in found.blueprints()] == ["tendril"]


@pytest.mark.process
def test_a_closed_file_leaves_no_memory_behind(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "tests.recordings.write_and_forget", str(tmp_path), "10", "30"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert float(done.stdout) < GROWTH_MAX_MB


@pytest.mark.parametrize("name", ["flush", "close"])
def test_a_writer_that_died_as_it_was_asked_is_not_waited_for(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """rerun's flush and end then wait for ever: the recorder hung in 3 of 20 full disks."""
    file = RrdFile(tmp_path / "a.rrd", About("a", "name", rig_info(), Settings(), "full"))
    stream, never = file._stream, threading.Event()

    def flush(timeout_sec: float) -> None:
        never.wait(timeout_sec)
        raise RuntimeError("Flush timed out - not all log messages were sent")

    file._stream = cast(rr.RecordingStream, SimpleNamespace(flush=flush, disconnect=never.wait))
    monkeypatch.setattr(rrd, "FLUSH_S", 0.01)
    asked = in_thread("asked", getattr(file, name))
    assert not wait([asked], 0.3).done  # a disk that is slow is waited for
    stream.disconnect()  # its writer ends
    with pytest.raises(RecordingError, match="disk full"):
        asked.result()
    never.set()


def test_the_next_recording_ends_though_one_before_it_hangs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What rerun keeps of ended recordings is freed by a call that waits for those, too."""
    first, second = (RrdFile(tmp_path / f"{k}.rrd", About("a", "name", rig_info(), Settings())) for k in range(2))
    stream, never = first._stream, threading.Event()
    first._stream = cast(rr.RecordingStream, SimpleNamespace(disconnect=never.wait))
    monkeypatch.setattr(rrd, "ABANDON_TIMEOUT", 0.01)
    monkeypatch.setattr(rrd, "release_streams", lambda: never.wait(60.0) or pytest.fail("it waits"))
    first.abandon()
    second.close()
    never.set()
    stream.disconnect()
    RrdFile(tmp_path / "2.rrd", About("a", "name", rig_info(), Settings())).close()


def test_what_rerun_says_of_a_flush_that_goes_on(tmp_path: Path) -> None:
    path = tmp_path / "pipe"
    os.mkfifo(path)
    reading = os.open(path, os.O_RDWR)  # and reads nothing: the writer stands
    stream = rr.RecordingStream("test")
    stream.save(path)
    for _ in range(50):
        stream.log("text", rr.TextDocument(os.urandom(20_000).hex()))
    with pytest.raises(RuntimeError, match=rrd.TIMED_OUT):
        stream.flush(timeout_sec=0.1)
    os.set_blocking(reading, False)
    while True:  # it goes on, and ends
        try:
            os.read(reading, 1 << 20)
        except BlockingIOError:
            try:
                stream.flush(timeout_sec=0.1)
                break
            except RuntimeError:
                continue
    stream.disconnect()
    os.close(reading)
