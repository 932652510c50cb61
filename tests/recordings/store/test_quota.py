"""What goes when all recordings together take too much, and what a file does that has grown too large."""

import time
from pathlib import Path

import numpy as np
import pytest

from controller.schema.parameters import Settings
from recordings.format import sidecar, tool
from recordings.format.messages import Recording
from recordings.read.reader import read_rows
from recordings.store.quota import bytes_on_disk, default_quota, enforce
from recordings.store.store import Store
from recordings.write.session import Context
from recordings.write.writer import BATCH_ROWS, Recorder
from tests.recordings.synthetic import batches, rig_info, telemetry_rows


def test_the_oldest_go_into_the_bin_but_neither_starred_nor_running_ones(recorder: Recorder, tmp_path: Path) -> None:
    store, ids = Store(tmp_path), []
    for name in ("starred", "old", "older", "new"):
        recorder.start(name, rig_info(), Settings())
        ids.append(recorder.stop().id)
    running = recorder.start("zz running", rig_info(), Settings()).id
    sidecar.write(tmp_path, store.find(ids[0]).model_copy(update={"starred": True}))
    order = [recording.id for recording in reversed(store.list())]
    takes = {id: bytes_on_disk(store, id) for id in order}
    [moved], over = enforce(store, sum(takes.values()) - 1)
    assert (moved.id, over) == (next(id for id in order if id not in (ids[0], running)), 0)
    left = {ids[0], running}
    enforce(store, sum(takes[id] for id in left))
    assert {recording.id for recording in store.list()} == left
    assert {recording.id for recording in store.bin.recordings()} == set(ids[1:]), "nothing is erased"
    for id in ids[1:]:
        assert store.restore(id).complete


def test_where_nothing_that_may_go_would_help_all_stay(recorder: Recorder, tmp_path: Path) -> None:
    store, ids = Store(tmp_path), []
    for name in ("starred", "old", "new"):
        recorder.start(name, rig_info(), Settings())
        ids.append(recorder.stop().id)
    sidecar.write(tmp_path, store.find(ids[0]).model_copy(update={"starred": True}))
    most = sum(bytes_on_disk(store, id) for id in (ids[0], ids[2])) - 1
    assert enforce(store, most) == ([], 1 + bytes_on_disk(store, ids[1]))
    assert {recording.id for recording in store.list()} == set(ids)


def test_a_file_that_someone_puts_there_displaces_no_recording(recorder: Recorder, tmp_path: Path) -> None:
    """Newest by its name: holes of 200 GB, as large a one without a description, a copy with that of another one."""
    store = Store(tmp_path)
    for name in ("a", "b"):
        recorder.start(name, rig_info(), Settings())
        recorder.rows(telemetry_rows(200))
        recorder.stop()
    ids = {one.id for one in store.list()}
    most = sum(bytes_on_disk(store, id) for id in ids)
    with (tmp_path / "20990101-000000-sparse.rrd").open("wb") as holes:
        holes.truncate(200 << 30)
    (tmp_path / "20990102-000000-filled.rrd").write_bytes(bytes(most + 1))
    for kind in ("rrd", "json"):
        copy = tmp_path / f"20990103-000000-copy.{kind}"
        copy.write_bytes((tmp_path / f"{min(ids)}.{kind}").read_bytes())
    described = "20990104-000000-sparse"
    sidecar.write(tmp_path, sidecar.blank(described).model_copy(update={"bytes": 200 << 30, "complete": True}))
    with (tmp_path / f"{described}.rrd").open("wb") as holes:
        holes.truncate(200 << 30)
    assert enforce(store, most) == ([], 0)
    assert ids < {one.id for one in store.list() if not one.problem}


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
