"""A power cut at any moment loses at most 1 s of the running recording, and nothing older.

A real recorder, rerun's own writer and tools are run; what they ask of the system is noted, and a cut is made after
each call, with everything lost that was not synced, or any part of it.
"""

import hashlib
import json
import os
import random
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from controller.errors import RecordingError
from controller.system.keys import read_key
from controller.system.whole_file import write_whole
from recordings.format import frames
from recordings.format.messages import Recording
from recordings.read.reader import read_times
from recordings.store.store import Store
from tests.recordings.power_cut import LOSSES, Disk, File, cuts
from tests.recordings.synthetic import telemetry_rows
from tests.recordings.system_calls import Call, record
from tests.recordings.write_through_power_cuts import ROWS

pytestmark = [pytest.mark.alone, pytest.mark.keyed()]

LOSS_MAX = 1000
"""Ticks: 1 s; more only for as long as the machine itself was late."""
MENDED = 60
"""One cut in this many is followed by a start, which mends; it runs rerun's own tools."""

LONG = os.environ.get("TENDRIL_LONG") == "1"

Left = dict[str, bytes]


@pytest.fixture
def older(record: Callable[..., Recording], tmp_path: Path) -> list[Recording]:
    found = [record(telemetry_rows(500), name) for name in ("edited", "removed")]
    return [Store(tmp_path).compact(one.id) for one in found]


def test_a_power_cut_loses_at_most_a_second_and_no_older_recording(older: list[Recording], tmp_path: Path) -> None:
    initial = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    done = record_calls(tmp_path, *(one.id for one in older))
    said: dict[str, str] = {}
    worst = 0
    for place, left in cuts(initial, done):
        if done[place].name == "said":
            what, _, value = done[place].data.decode().strip().partition(" ")
            said[what] = value
        for loss, files in left.items():
            if not LONG and (place + LOSSES.index(loss)) % 3:
                continue  # every place loses in one or two ways, in the next ones in the others
            where = f"call {place} of {len(done)}, {done[place].name} {done[place].path}, lost: {loss}"
            require_older(files, initial, older, said, where)
            if "started" in said:
                worst = max(worst, require_running(files, said, where))
            require_state(files, said, where)
            if place % MENDED == 0 or place == len(done) - 1:
                require_start(files, older, said, where)
    assert {"started", "edited", "stopped", "compacted", "removed", "imported", "key"} <= said.keys()
    print(f"{len(done)} calls, {len(done) * len(LOSSES)} cuts, worst loss {worst} ms")


def record_calls(folder: Path, *ids: str) -> list[Call]:
    done = record(folder, "tests.recordings.write_through_power_cuts", str(folder), *ids)
    assert done.code == 0
    return done.calls


def require_older(files: Left, initial: Left, older: list[Recording], said: dict[str, str], where: str) -> None:
    """Those that were there before are as they were, but for what was asked."""
    edited, removed = older
    assert files[f"{edited.id}.rrd"] == initial[f"{edited.id}.rrd"], where
    name = Recording.model_validate_json(files[f"{edited.id}.json"]).name
    assert name in (("new name",) if "edited" in said else ("edited", "new name")), where
    parts = [files.get(f"{removed.id}.{kind}") for kind in ("rrd", "json")]
    if "removing" not in said:
        assert parts == [initial[f"{removed.id}.{kind}"] for kind in ("rrd", "json")], where
    if "removed" in said:
        assert parts == [None, None], where


def require_running(files: Left, said: dict[str, str], where: str) -> int:
    """Ticks that are lost of the one that was written."""
    id, (given, late) = said["started"], handed_over(said)
    rows, closed = held(files[f"{id}.rrd"])
    lost = given + 1 - rows
    assert lost <= LOSS_MAX + late, f"{lost} ticks are lost, machine late by {late}: {where}"
    described = Recording.model_validate_json(files[f"{id}.json"])
    if described.complete:
        assert (rows, closed) == (ROWS, True), f"called complete with {rows} rows: {where}"
    assert described.complete or "stopped" not in said, where
    return lost


def handed_over(said: dict[str, str]) -> tuple[int, int]:
    """The last tick that the recorder had been given, and how late the machine let it be [ticks]."""
    tick, late = said.get("tick", "-1 0").split()
    return int(tick), int(late)


def require_state(files: Left, said: dict[str, str], where: str) -> None:
    """What is kept whole is there whole or not at all, and for good once it was said."""
    if "imported" in said:
        assert held(files[f"{said['imported']}.rrd"]) == (3, True), where
        assert json.loads(files[f"{said['imported']}.json"])["complete"], where
    if "key" in said or "rig.key" in files:
        with tempfile.TemporaryDirectory() as folder:
            write_whole(Path(folder, "rig.key"), files["rig.key"], lasting=False)
            assert len(read_key(Path(folder, "rig.key"))) == 32, where


def require_start(files: Left, older: list[Recording], said: dict[str, str], where: str) -> None:
    """The next start lists and mends what is there."""
    with tempfile.TemporaryDirectory() as folder:
        fill(Path(folder), files)
        store = Store(Path(folder))
        for id in store.broken():
            try:
                store.repair(id)
            except RecordingError:
                assert id != said.get("started"), where
        listed = {one.id: one for one in store.list()}
        assert not listed[older[0].id].problem, where
        if "started" in said:
            found = listed[said["started"]]
            assert not found.problem and (found.complete or found.recovered), where
            given, late = handed_over(said)
            assert found.rows >= given + 1 - LOSS_MAX - late, where


def fill(folder: Path, files: Left) -> None:
    for name, data in files.items():
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(data)
        path.chmod(0o600)


def held(data: bytes) -> tuple[int, bool]:
    """Rows that can be read, and whether the file has its proper end."""
    digest = hashlib.sha256(data).hexdigest()
    _bytes[digest] = data
    return _held(digest)


_bytes: dict[str, bytes] = {}


@cache
def _held(digest: str) -> tuple[int, bool]:
    with tempfile.TemporaryDirectory() as folder:
        path, whole = Path(folder, "left.rrd"), Path(folder, "whole.rrd")
        path.write_bytes(_bytes.pop(digest))
        closed = frames.extent(path).closed
        frames.copy_whole(path, whole, frames.intact_length(path))
        return len(read_times(whole)[0]), closed


def test_what_was_not_synced_may_be_lost_and_what_was_never_is() -> None:
    """The model itself: a rename before the fsync of its data can leave an empty file."""
    disk = Disk({"file": b"old"})
    for name, path, to, data in [
        ("create", "draft", "", b""),
        ("write", "draft", "", b"new"),
        ("rename", "draft", "file", b""),
    ]:
        disk.apply(Call(1, 0.0, name, path, to, data=data))
    chance = random.Random(1)
    assert [disk.left(loss, chance).get("file") for loss in LOSSES[:4]] == [b"old", b"new", b"", b"old"]
    disk.apply(Call(1, 0.0, "sync", "file"))
    assert (disk.left("all", chance), disk.left("data", chance)) == ({"file": b"old"}, {"file": b"new"})
    disk.apply(Call(1, 0.0, "sync", "."))
    assert disk.left("all", chance) == {"file": b"new"}
    torn = File(b"\1" * 8192, [(4096, b"\2" * 12288)])
    pages = {bytes({*torn.torn(random.Random(seed))[at : at + 4096]}) for seed in range(20) for at in (4096, 8192)}
    assert pages == {b"\1", b"\2", b"\0"}


def test_the_recorder_sees_what_is_not_synced(tmp_path: Path) -> None:
    """A draft that takes its place without an fsync is found out."""
    calls = record(tmp_path, "tests.recordings.write_without_sync", str(tmp_path / "file")).calls
    left = [found for _, found in cuts({"file": b"old"}, calls)]
    assert left[-1]["nothing"] == {"file": b"new"}
    assert b"" in [found["data"]["file"] for found in left]
