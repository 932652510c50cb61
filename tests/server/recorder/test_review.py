"""The thread behind the Review tab: what is left behind by a killed writer is mended, or said to be damaged."""

import json
import os
import signal
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, cast

import pytest

from controller.errors import ProcessKilled
from recordings.format import sidecar
from recordings.format.messages import Recording
from recordings.read import prepared, quick
from recordings.store.store import Store
from server.recorder.folder import Reader
from server.recorder.review import Review
from tests.e2e.recorded import record_circle
from tests.server.live_server import READER, wait_for


@pytest.mark.process
def test_what_cannot_be_mended_is_listed_with_the_reason(tmp_path: Path) -> None:
    started = datetime(2026, 11, 20, 12, tzinfo=UTC)
    id, lock = sidecar.claim(tmp_path, "torn", started)
    lock.close()
    (tmp_path / f"{id}.rrd").write_bytes(b"no rerun data at all")
    left = Recording(
        id=id,
        name="torn",
        started=started,
        seconds=0.0,
        rows=0,
        gaps=0,
        bytes=20,
        actuator="P1",
        twin=True,
        complete=False,
    )
    sidecar.write(tmp_path, left)
    store = Store(tmp_path)
    assert store.list()[0].problem == ""
    Review(store, READER)
    assert "verify failed" in wait_for(lambda: store.list()[0].problem, "the reason")
    assert not store.list()[0].recovered


@pytest.mark.process
def test_a_killed_reader_loses_no_recording_and_all_are_finished(tmp_path: Path) -> None:
    store = Store(tmp_path)
    done = [record_circle(tmp_path, f"circle {n}", 10.0) for n in range(2)]
    reader = Reader(nice=0)
    thread = Review(store, reader)
    wait_for(lambda: thread.viewer or thread.problem, "the viewer's files")
    thread.stopped(done[0].id)
    wait_for(lambda: (tmp_path / f".draft-{done[0].id}").exists(), "a draft")
    os.kill(cast(int, reader.pid), signal.SIGKILL)
    thread.stopped(done[1].id)
    for recording in done:
        finished = wait_for(lambda id=recording.id: (found := store.find(id)).metrics and found, "its metrics")
        assert finished.bytes < recording.bytes
    assert not [*tmp_path.glob(".draft-*/*.rrd")]
    reader.stop()


def test_a_reader_that_is_killed_again_and_again_leaves_the_recording_as_it_was(tmp_path: Path) -> None:
    store, done = Store(tmp_path), record_circle(tmp_path, "circle", 3.0)
    before = store.path(done.id).read_bytes()
    killed = Killed()
    Review(store, cast(Reader, killed)).stopped(done.id)
    wait_for(lambda: killed.left and not killed.left.exists(), "the draft to be swept")
    assert store.find(done.id) == done
    assert store.path(done.id).read_bytes() == before


@pytest.mark.process
def test_a_finished_recording_opens_from_what_was_kept_beside_it_until_its_data_change(tmp_path: Path) -> None:
    store, id = Store(tmp_path), record_circle(tmp_path, "circle", 3.0).id
    path = store.path(id)
    read = quick.quick_look(path, 2000, ("u.0",))
    Review(store, READER).stopped(id)
    wait_for(lambda: prepared.kept(path, prepared.mark(path)), "the quick look")
    quick._quick.cache_clear()
    kept = tmp_path / f".{id}.quick"
    assert quick.quick_look(path, 2000, ("u.0",)) == read
    kept.write_bytes(kept.read_bytes().replace(b'"rows":3000', b'"rows":4321'))
    quick._quick.cache_clear()
    assert json.loads(quick.quick_look(path, 2000))["rows"] == 4321  # so it was not read from the data
    kept.write_bytes(kept.read_bytes()[:-1])
    quick._quick.cache_clear()
    assert quick.quick_look(path, 2000, ("u.0",)) == read
    quick.prepare(path)
    path.touch()
    assert prepared.kept(path, prepared.mark(path)) is None
    store.remove(id)
    assert not kept.exists()


@pytest.mark.process
def test_an_error_that_nobody_expects_in_one_recording_keeps_no_other_from_being_finished(
    tmp_path: Path,
) -> None:
    store = Store(tmp_path)
    ids, asked = [record_circle(tmp_path, f"circle {n}", 3.0).id for n in range(2)], []

    class FailsOnce:
        def call(self, work: Any, folder: Path, id: str) -> Any:
            asked.append(id)
            if id == ids[0]:
                raise ValueError("the file is gone in the midst")
            return work(folder, id)

    thread = Review(store, cast(Reader, FailsOnce()))
    for id in ids:
        thread.stopped(id)
    wait_for(lambda: store.find(ids[1]).metrics, "the next one's metrics")
    assert asked == ids


class Killed:
    """Stands for a reader that the system kills whatever it reads."""

    left: Path | None = None

    def call(self, work: Any, folder: Path, id: str) -> Any:
        left = folder / f".draft-{id}"
        left.mkdir()
        self.left = left
        raise ProcessKilled("reading recordings: its process was killed twice, perhaps for want of memory")
