"""What is deleted can be taken back, whenever a kill comes, until its time is over or its room is needed."""

import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from controller.errors import CommandRefused, RecordingError
from recordings.format.messages import Recording
from recordings.read import prepared
from recordings.store import quota
from recordings.store.bin import DAYS
from recordings.store.quota import clear_bin, enforce
from recordings.store.store import Store
from tests.recordings.synthetic import telemetry_rows

Record = Callable[..., Recording]


class Killed(BaseException):
    """The process ends here."""


class Usage(NamedTuple):
    free: int
    total: int = 1 << 40


def files(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in folder.glob("*-*") if file.suffix in (".json", ".rrd")}


def test_what_is_deleted_is_restored_as_it_was(record: Record, tmp_path: Path) -> None:
    store, id = Store(tmp_path), record(telemetry_rows(300)).id
    before = files(tmp_path)
    prepared.keep(store.path(id), prepared.mark(store.path(id)), b"kept")
    store.remove(id)
    assert (store.list(), [found.id for found in store.bin.recordings()]) == ([], [id])
    for ask in (store.find, store.path):
        with pytest.raises(RecordingError, match="there is no recording"):
            ask(id)
    assert store.restore(id) == store.find(id)
    assert files(tmp_path) == before
    assert prepared.kept(store.path(id), prepared.mark(store.path(id))) == b"kept"
    with pytest.raises(RecordingError, match="no deleted recording"):
        store.restore(id)
    with pytest.raises(RecordingError, match="not the id"):
        store.restore("../secrets")


@pytest.mark.parametrize("act", ["remove", "restore"])
@pytest.mark.parametrize("done", [0, 1])
def test_a_kill_between_two_renames_leaves_it_whole_here_or_there(
    record: Record, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, act: str, done: int
) -> None:
    store, id = Store(tmp_path), record(telemetry_rows(300)).id
    before = files(tmp_path)
    if act == "restore":
        store.remove(id)
    renames, plain = 0, Path.rename

    def rename(source: Path, target: Any) -> Path:
        nonlocal renames
        if source.suffix not in (".json", ".rrd"):
            return plain(source, target)
        renames += 1
        if renames > done:
            raise Killed
        return plain(source, target)

    monkeypatch.setattr(Path, "rename", rename)
    with pytest.raises(Killed):
        getattr(store, act)(id)
    monkeypatch.undo()
    again = Store(tmp_path)
    again.sweep()
    here, there = [found.id for found in again.list()], [found.id for found in again.bin.recordings()]
    assert [*here, *there] == [id], "in one place"
    if there:
        again.restore(id)
    assert files(tmp_path) == before
    assert [found.problem for found in again.list()] == [""]


def test_an_id_that_is_taken_again_is_not_written_over(record: Record, tmp_path: Path) -> None:
    store, id = Store(tmp_path), record(telemetry_rows(300)).id
    kept = files(tmp_path)
    store.remove(id)
    for name, data in kept.items():
        (tmp_path / name).write_bytes(data)
    with pytest.raises(CommandRefused, match="another one"):
        store.restore(id)
    assert [found.id for found in store.bin.recordings()] == [id]


def test_deleted_ones_go_before_any_other_and_after_their_time(
    record: Record, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = Store(tmp_path)
    first, second, kept = (record(telemetry_rows(300), name).id for name in ("first", "second", "kept"))
    for id in (first, second):
        store.remove(id)
        time.sleep(0.02)  # times of change are as coarse as the kernel's ticks
    total = sum(found.bytes for found in (*store.list(), *store.bin.recordings()))
    assert enforce(store, total - 1) == []
    assert [found.id for found in store.bin.recordings()] == [second], "the longest deleted first"
    over = clear_bin(store, 0 - total, now=time.time() + (DAYS + 1) * 86_400.0)
    assert (store.bin.recordings(), over) == ([], -total)
    assert [found.id for found in store.list()] == [kept]
    store.remove(kept)
    monkeypatch.setattr(quota.shutil, "disk_usage", lambda _: Usage(free=1 << 29))
    enforce(store, total)
    assert store.bin.recordings() == [], "a disk that is nearly full keeps nothing deleted"
    assert not list((tmp_path / ".deleted").glob("*.rrd"))
    assert shutil.disk_usage(tmp_path)
