"""A disk that hangs while a recording is to end: who asked waits no longer than said, and it ends all the same."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from controller.errors import RecordingError
from controller.schema.parameters import Settings
from recordings.format.messages import Recording
from recordings.read.reader import read_rows
from recordings.store.store import Store
from recordings.write import writer
from recordings.write.rrd import RrdFile
from recordings.write.writer import Recorder
from tests.recordings.synthetic import batches, rig_info, telemetry_rows

ROWS = telemetry_rows(1500)


@contextmanager
def hanging(method: str, monkeypatch: pytest.MonkeyPatch) -> Iterator[threading.Event]:
    """`method` of the file does not come back before the end of this; the event says that it was called.

    Meanwhile no one waits for longer than 0.3 s.
    """
    over, reached, true = threading.Event(), threading.Event(), getattr(RrdFile, method)

    def wait(file: RrdFile, *arguments: object) -> None:
        reached.set()
        over.wait(60.0)
        true(file, *arguments)

    monkeypatch.setattr(RrdFile, method, wait)
    monkeypatch.setattr(writer, "ANSWER", 0.3)
    try:
        yield reached
    finally:
        monkeypatch.setattr(writer, "ANSWER", 40.0)
        over.set()


@contextmanager
def recording(folder: Path, ended: Callable[[Recording], None], patience: float = 10.0) -> Iterator[Recorder]:
    recorder = Recorder(folder, ended=ended, patience=patience)
    recorder.start("Circle", rig_info(), Settings())
    try:
        yield recorder
    finally:
        recorder.close()


def wait_for(what: Callable[[], object], text: str, looking: Recorder | None = None) -> None:
    end = time.monotonic() + 30.0
    while not what():
        assert time.monotonic() < end, f"waited in vain for {text}"
        if looking:
            looking.look()
        time.sleep(0.01)


@pytest.mark.parametrize("method", ["write", "close"])
def test_it_ends_whole_when_the_disk_is_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, method: str) -> None:
    """Before its end was begun, and in the middle of it."""
    told: list[Recording] = []
    with recording(tmp_path, told.append) as recorder:
        with hanging(method, monkeypatch) as reached:
            for batch in batches(ROWS, 250):
                recorder.rows(batch)
            if method == "write":
                assert reached.wait(30.0)
            with pytest.raises(RecordingError, match="does not answer"):
                recorder.stop()
        wait_for(lambda: not recorder.state().recording, "the end")
        wait_for(lambda: told, "word of it")
        [left] = Store(tmp_path).list()
        assert told == [left] and left.complete and left.rows == len(ROWS)
        np.testing.assert_array_equal(read_rows(tmp_path / f"{left.id}.rrd")["tick"], ROWS["tick"])
        recorder.start("another", rig_info(), Settings())
        recorder.rows(telemetry_rows(300, first=3000))
        assert recorder.stop().complete
    assert len(told) == 1


@pytest.mark.parametrize("method", ["write", "close"])
def test_a_disk_that_does_not_come_back_is_told_and_watched_as_ever(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, method: str
) -> None:
    with recording(tmp_path, lambda done: None, patience=0.6) as recorder:
        with hanging(method, monkeypatch) as reached:
            recorder.rows(ROWS[:500])
            if method == "write":
                assert reached.wait(30.0)
            with pytest.raises(RecordingError, match="does not answer"):
                recorder.stop()
            wait_for(lambda: not recorder.state().recording, "the end", looking=recorder)
            assert "the disk has taken nothing for 0.6 s" in recorder.state().problem
            with pytest.raises(RecordingError, match="does not answer"):
                recorder.start("too early", rig_info(), Settings())
        wait_for(lambda: not recorder.worker.stuck, "the disk")
        wait_for(lambda: can_start(recorder), "another recording")
        recorder.rows(telemetry_rows(300, first=3000))
        assert recorder.stop().complete


def can_start(recorder: Recorder) -> bool:
    try:
        recorder.start("another", rig_info(), Settings())
    except RecordingError:
        return False
    return True
