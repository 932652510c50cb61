"""What is deleted can be taken back, whenever a kill comes, until its time is over."""

import shutil
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from controller.errors import CommandRefused, RecordingError
from recordings.format.messages import Recording
from recordings.read import prepared
from recordings.store import age
from recordings.store.bin import AGES, KEPT_S
from recordings.store.quota import enforce
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


@dataclass
class Machine:
    """The clock by which things in the bin grow older."""

    boot: str = "first"
    seconds: float = 1000.0

    def time(self) -> tuple[str, float]:
        return self.boot, self.seconds


@pytest.fixture
def machine(monkeypatch: pytest.MonkeyPatch) -> Machine:
    machine = Machine()
    monkeypatch.setattr(age, "machine_time", machine.time)
    return machine


def test_what_was_deleted_goes_once_the_machine_has_run_for_seven_days(
    record: Record, tmp_path: Path, machine: Machine
) -> None:
    store = Store(tmp_path)
    first, second = (record(telemetry_rows(300), name).id for name in ("first", "second"))
    store.remove(first)
    assert store.clear_bin() == ()
    machine.seconds += KEPT_S
    store.remove(second)
    assert store.clear_bin() == ()
    machine.seconds += 1.0
    assert store.clear_bin() == (first,)
    assert [found.id for found in store.bin.recordings()] == [second]
    assert not list((tmp_path / ".deleted").glob(f"{first}*"))
    machine.seconds += KEPT_S
    assert store.clear_bin() == (second,)


def test_no_other_boot_and_no_return_of_a_recording_makes_it_older(
    record: Record, tmp_path: Path, machine: Machine
) -> None:
    store, id = Store(tmp_path), record(telemetry_rows(300)).id
    store.remove(id)
    assert store.clear_bin() == ()
    machine.boot, machine.seconds = "second", 10 * KEPT_S
    assert store.clear_bin() == ()
    machine.seconds += 0.9 * KEPT_S
    assert store.clear_bin() == ()
    store.restore(id)
    store.remove(id)
    machine.seconds += 0.9 * KEPT_S
    assert store.clear_bin() == (), "it lies there anew"
    (tmp_path / ".deleted" / AGES).write_text("{")
    assert store.clear_bin() == (), "nor does a damaged file of ages"
    machine.seconds += 1.1 * KEPT_S
    assert store.clear_bin() == (id,)


def test_a_clock_that_jumps_forward_by_years_removes_nothing(
    record: Record, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store, id = Store(tmp_path), record(telemetry_rows(300)).id
    store.remove(id)
    assert store.clear_bin() == ()
    years = time.time() + 3e8
    monkeypatch.setattr(time, "time", lambda: years)
    assert store.clear_bin() == () == Store(tmp_path).clear_bin()
    assert [found.id for found in store.bin.recordings()] == [id]


def test_neither_a_disk_that_is_nearly_full_nor_the_quota_clears_the_bin(
    record: Record, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = Store(tmp_path)
    first, second = (record(telemetry_rows(300), name).id for name in ("first", "second"))
    store.remove(first)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: Usage(free=0))
    assert enforce(store, 0).moved == []
    assert store.clear_bin() == ()
    assert store.restore(first).complete and store.find(second).complete
