"""The thread behind the Review tab: what is left behind by a killed writer is mended, or said to be damaged."""

import json
import multiprocessing
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import pytest

from recordings.format import sidecar
from recordings.format.messages import Recording
from recordings.read import prepared, quick
from recordings.store.store import Store
from server.recorder import review
from server.recorder.review import Review
from tests.e2e.recorded import record_circle
from tests.server.live_server import wait_for


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
    Review(store)
    assert "verify failed" in wait_for(lambda: store.list()[0].problem, "the reason")
    assert not store.list()[0].recovered


def test_a_killed_helper_loses_no_recording_and_the_next_one_is_finished(tmp_path: Path) -> None:
    store = Store(tmp_path)
    done = [record_circle(tmp_path, f"circle {n}", 10.0) for n in range(2)]
    before = store.path(done[0].id).read_bytes()
    thread = Review(store)
    wait_for(lambda: thread.viewer or thread.problem, "the viewer's files")
    thread.stopped(done[0].id)
    wait_for(lambda: (tmp_path / f".draft-{done[0].id}").exists(), "a draft")
    for helper in multiprocessing.active_children():
        helper.kill()
    thread.stopped(done[1].id)
    finished = wait_for(lambda: (found := store.find(done[1].id)).metrics and found, "the next one's metrics")
    assert finished.bytes < done[1].bytes
    assert store.find(done[0].id) == done[0]
    assert store.path(done[0].id).read_bytes() == before
    assert not [*tmp_path.glob(".draft-*/*.rrd")]


def test_a_finished_recording_opens_from_what_was_kept_beside_it_until_its_data_change(tmp_path: Path) -> None:
    store, id = Store(tmp_path), record_circle(tmp_path, "circle", 3.0).id
    path = store.path(id)
    read = quick.quick_look(path, 2000, ("u.0",))
    Review(store).stopped(id)
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


def test_an_error_that_nobody_expects_in_one_recording_keeps_no_other_from_being_finished(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = Store(tmp_path)
    ids, asked = [record_circle(tmp_path, f"circle {n}", 3.0).id for n in range(2)], []

    def fails_once(work: Callable[..., object], folder: Path, id: str) -> object:
        asked.append(id)
        if id == ids[0]:
            raise ValueError("the file is gone in the midst")
        return work(folder, id)

    monkeypatch.setattr(review, "apart", fails_once)
    thread = Review(store)
    for id in ids:
        thread.stopped(id)
    wait_for(lambda: store.find(ids[1]).metrics, "the next one's metrics")
    assert asked == ids
