"""A disk that takes nothing for a while: the recording goes on in memory, says so, and catches up.

The disk is a pipe that rerun writes into, and a reader that puts what comes into the recording's file, or does not.
"""

import os
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import rerun as rr

from controller.schema.parameters import Settings
from recordings.read.reader import read_rows
from recordings.store.store import Store
from recordings.write.writer import Recorder
from tests.recordings.synthetic import batches, rig_info, telemetry_rows
from tests.waiting import wait_for

NOTHING_S = 12.0
"""Longer than rerun's flush and the recorder waited when they took such a disk for dead."""
TAKEN_AT_ONCE = 1 << 16


class Disk:
    """Takes what is written for `path`, while it `takes`."""

    def __init__(self, path: Path, pipe: Path) -> None:
        self.takes = threading.Event()
        self.takes.set()
        os.mkfifo(pipe)
        self._reading = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
        os.set_blocking(self._reading, True)
        self._file = path.open("wb", buffering=0)
        self._thread = threading.Thread(target=self._take, daemon=True)

    def start(self) -> None:
        self._thread.start()

    def close(self) -> None:
        """Take all that is left."""
        self.takes.set()
        self._thread.join()

    def _take(self) -> None:
        while data := os.read(self._reading, TAKEN_AT_ONCE):
            self.takes.wait()
            self._file.write(data)
        os.close(self._reading)
        self._file.close()


@pytest.fixture
def disks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[dict[str, Disk]]:
    """Of each recording in `tmp_path`, by its file's name."""
    found: dict[str, Disk] = {}
    true = rr.RecordingStream.save

    def save(stream: rr.RecordingStream, path: Path) -> None:
        if not path.is_relative_to(tmp_path):
            return true(stream, path)
        pipe = path.with_suffix(".pipe")
        disk = found[path.name] = Disk(path, pipe)
        true(stream, pipe)
        disk.start()

    monkeypatch.setattr(rr.RecordingStream, "save", save)
    yield found
    for disk in found.values():
        disk.close()


def test_a_recording_outlasts_a_disk_that_takes_nothing_and_has_every_row(
    tmp_path: Path, disks: dict[str, Disk]
) -> None:
    recorder, rows = Recorder(tmp_path), telemetry_rows(8000)
    id = recorder.start("slow disk", rig_info(), Settings()).id
    given = iter(batches(rows, 16))

    def give_and_look(what: bool) -> bool:
        recorder.look()
        assert recorder.state().recording, recorder.state().problem
        if (batch := next(given, None)) is not None:
            recorder.rows(batch)
        return what

    wait_for(lambda: give_and_look(recorder.state().rows > 500), "rows")
    disks[f"{id}.rrd"].takes.clear()
    stopped = time.monotonic()
    wait_for(lambda: give_and_look("the disk took nothing" in recorder.state().problem), "word of it")
    wait_for(lambda: give_and_look(time.monotonic() - stopped > NOTHING_S), "a while")
    disks[f"{id}.rrd"].takes.set()
    wait_for(lambda: give_and_look(not recorder.state().problem), "the disk to catch up")
    for batch in given:
        recorder.rows(batch)
    done = recorder.stop()
    recorder.close()
    disks[f"{id}.rrd"].close()
    assert (done.complete, done.gaps, done.rows, done.id) == (True, 0, len(rows), id)
    assert Store(tmp_path).find(id).problem == ""
    np.testing.assert_array_equal(np.sort(read_rows(tmp_path / f"{id}.rrd")["tick"]), rows["tick"])
