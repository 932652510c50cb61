"""What goes when all recordings together take too much, and what a file does that has grown too large."""

import time
from pathlib import Path

import numpy as np
import pytest

from controller.schema.parameters import Settings
from recordings.format import sidecar, tool
from recordings.format.messages import Recording
from recordings.read.reader import read_rows
from recordings.store.quota import default_quota, enforce
from recordings.store.store import Store
from recordings.write.session import Context
from recordings.write.writer import BATCH_ROWS, Recorder
from tests.recordings.synthetic import batches, rig_info, telemetry_rows


def test_the_oldest_go_first_but_neither_starred_nor_running_ones(recorder: Recorder, tmp_path: Path) -> None:
    store, ids = Store(tmp_path), []
    for name in ("starred", "old", "older", "new"):
        recorder.start(name, rig_info(), Settings())
        ids.append(recorder.stop().id)
    running = recorder.start("zz running", rig_info(), Settings()).id
    sidecar.write(tmp_path, store.find(ids[0]).model_copy(update={"starred": True}))
    order = [recording.id for recording in reversed(store.list())]
    total = sum(recording.bytes for recording in store.list())
    removed = enforce(store, total - 1)
    assert [recording.id for recording in removed] == [next(id for id in order if id not in (ids[0], running))]
    enforce(store, 0)
    assert {recording.id for recording in store.list()} == {ids[0], running}
    assert {path.stem for path in tmp_path.glob("*.rrd")} == {ids[0], running}
    assert enforce(store, total) == []


def test_by_default_no_more_than_50_gb_or_most_of_a_small_disk(tmp_path: Path) -> None:
    assert 0 < default_quota(tmp_path) <= 50e9


@pytest.mark.process
def test_a_file_that_grows_too_large_goes_on_in_another_without_a_missing_tick(tmp_path: Path) -> None:
    ended: list[Recording] = []
    recorder, rows = Recorder(tmp_path, split=1_000_000, ended=ended.append), telemetry_rows(6000)
    recorder.start("long", rig_info(), Settings(), Context(operator="ann"))
    for batch in batches(rows, BATCH_ROWS):
        before = recorder.state()
        recorder.rows(batch)
        while recorder.state() is before:  # as slowly as it writes on a busy machine
            time.sleep(0.005)
    last = recorder.stop()
    recorder.close()
    parts = [*ended, last]
    assert len(ended) >= 2
    assert all(part.bytes < 1_600_000 and part.complete and part.operator == "ann" for part in parts)
    assert [part.part_of for part in parts] == ["", *[parts[0].id] * (len(parts) - 1)]
    assert sum(part.gaps for part in parts) == 0
    ticks = [read_rows(tmp_path / f"{part.id}.rrd")["tick"] for part in parts]
    assert np.concatenate(ticks).tolist() == list(range(6000))
    tool.run("rrd", "verify", str(tmp_path / f"{ended[0].id}.rrd"), timeout=60)


def test_a_damaged_recording_counts_with_the_room_that_it_takes(tmp_path: Path) -> None:
    """Not with what its description says, or cannot say: nothing whole goes in its place."""
    ids = [f"2020010{n}-000000" for n in range(1, 5)]
    unreadable, bare, whole, newest = ids
    for id in ids:
        (tmp_path / f"{id}.rrd").write_bytes(bytes(1000))
        (tmp_path / f"{id}.json").write_text("{")
    (tmp_path / f"{bare}.json").unlink()
    for id in (whole, newest):
        sidecar.write(tmp_path, sidecar.blank(id).model_copy(update={"bytes": 1000, "complete": True}))
    lost = "20200105-000000"  # nothing is left of its data
    sidecar.write(tmp_path, sidecar.blank(lost).model_copy(update={"bytes": 10_000, "complete": True, "starred": True}))
    store = Store(tmp_path)
    assert enforce(store, 4000) == []
    assert [one.id for one in enforce(store, 3000)] == [unreadable]
    assert [one.id for one in enforce(store, 2000)] == [bare]
    assert {one.id for one in store.list()} == {whole, newest, lost}
