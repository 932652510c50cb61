"""What exports leave on the disk of the server: nothing, however they are fetched, and never too little room."""

import contextlib
import fcntl
import os
import shutil
import socket
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest
from starlette.requests import Request

from controller.errors import RecordingError
from controller.system.scheduler import Scheduler
from recordings.exporting.export import By
from recordings.exporting.table import Choice
from recordings.format.messages import Recording
from server.recorder import exports as exports_module
from server.recorder import scratch as scratch_module
from server.recorder.exports import Exports
from server.recorder.folder import RecordingsFolder
from server.recorder.scratch import Scratch, sweep
from tests.recordings.synthetic import recorded, telemetry_rows
from tests.server.live_server import Page, TestServer, rigless, wait_for

pytestmark = pytest.mark.process

PLENTY = 1 << 60


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestServer]:
    """A server that no rig has ever spoken to: exports need none."""
    yield from rigless(tmp_path_factory.mktemp("server"))


@pytest.fixture(scope="module")
def done(server: TestServer) -> Recording:
    folder = server.settings.recordings
    assert folder is not None
    return recorded(folder, "Circle", telemetry_rows(6500))


@pytest.fixture
def page(server: TestServer) -> Page:
    return server.page().sign_in()


@pytest.fixture
def room(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where files are made that are on their way."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def is_empty(folder: Path) -> bool:
    return not [*folder.iterdir()]


def made(page: Page, done: Recording, kind: str = "rrd") -> str:
    """Key of an export that waits to be fetched."""
    answer = page.post(f"/api/recordings/{done.id}/exports", json={"format": kind})
    assert answer.status_code == 200, answer.text
    return str(answer.json()["key"])


@pytest.mark.parametrize("door", ["export", "shown.rrd", "key"])
@pytest.mark.parametrize(("asked", "status"), [("bytes=999999999-", 416), ("bytes=x", 400), ("bytes=0-9", 206)])
def test_a_range_of_any_kind_leaves_nothing(
    page: Page, done: Recording, room: Path, door: str, asked: str, status: int
) -> None:
    """As `curl -C -` asks for what is whole already."""
    url = f"/api/exports/{made(page, done)}" if door == "key" else f"/api/recordings/{done.id}/{door}"
    answer = page.get(url, params={"format": "rrd"} if door == "export" else {}, headers={"range": asked})
    assert answer.status_code == status
    wait_for(lambda: is_empty(room), "an empty folder")


def test_who_hangs_up_in_the_middle_leaves_nothing(server: TestServer, page: Page, done: Recording, room: Path) -> None:
    key, address = made(page, done), page.base_url
    cookies = "; ".join(f"{name}={value}" for name, value in page.cookies.items())
    with contextlib.closing(socket.create_connection((address.host, address.port))) as connection:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        request = f"GET /api/exports/{key} HTTP/1.1\r\nhost: {address.host}:{address.port}\r\ncookie: {cookies}\r\n\r\n"
        connection.sendall(request.encode())
        assert connection.recv(100).startswith(b"HTTP/1.1 200")
    wait_for(lambda: is_empty(room), "an empty folder")


def test_what_nobody_fetches_goes_by_itself(
    page: Page, done: Recording, room: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    key = made(page, done)
    assert not is_empty(room)
    monkeypatch.setattr(exports_module, "KEPT", 0.0)
    wait_for(lambda: is_empty(room), "an empty folder")
    late = page.get(f"/api/exports/{key}")
    assert late.status_code == 404 and "too old" in late.json()["detail"]


async def test_what_is_too_old_is_not_given_before_the_next_beat_either(
    room: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def write(_: object, __: Path, target: Path, *rest: object) -> None:
        target.write_text("t,x,y")

    async def present() -> bool:
        return False

    exports, folder = Exports(Scheduler()), cast(RecordingsFolder, SimpleNamespace(read=write))
    request = cast(Request, SimpleNamespace(is_disconnected=present))
    key = (await exports.make(folder, request, Path("run.rrd"), "csv", Choice(), By())).key
    monkeypatch.setattr(exports_module, "KEPT", 0.0)
    with pytest.raises(RecordingError, match="too old"):
        exports.take(key)
    exports.close()
    assert is_empty(room)


@pytest.mark.parametrize("door", ["export", "shown.rrd", "exports"])
def test_an_export_is_refused_where_too_little_room_would_be_left(
    page: Page, done: Recording, room: Path, monkeypatch: pytest.MonkeyPatch, door: str
) -> None:
    monkeypatch.setattr(exports_module, "LEFT_MIN", PLENTY)
    monkeypatch.setattr(exports_module, "LEFT_SHARE", PLENTY)
    url = f"/api/recordings/{done.id}/{door}"
    answer = page.post(url, json={"format": "csv"}) if door == "exports" else page.get(url, params={"format": "csv"})
    told = answer.json()["detail"]
    assert answer.status_code == 409
    assert "MiB are free" in told and f"at least {PLENTY >> 20} MiB" in told and str(room) in told and "TMPDIR" in told
    assert is_empty(room)


def test_a_copy_is_refused_before_it_fills_the_disk(
    page: Page, done: Recording, room: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its size is known, and it is written faster than anybody could look."""
    least = exports_module.least(room)
    usage = shutil.disk_usage(room)._replace(free=least + done.bytes - 1)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage)
    assert page.get(f"/api/recordings/{done.id}/export", params={"format": "rrd"}).status_code == 409
    assert page.get(f"/api/recordings/{done.id}/export", params={"format": "csv", "to": 0.1}).status_code == 200
    wait_for(lambda: is_empty(room), "an empty folder")


def test_one_that_fills_the_disk_is_ended(
    page: Page, done: Recording, room: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    usage = shutil.disk_usage(room)
    answers = iter([usage])
    monkeypatch.setattr(exports_module, "CHECK_S", 0.0)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: next(answers, usage._replace(free=0)))
    answer = page.get(f"/api/recordings/{done.id}/export", params={"format": "csv"})
    assert answer.status_code == 409 and "0 MiB are free" in answer.json()["detail"]
    wait_for(lambda: is_empty(room), "an empty folder")


def test_only_so_many_wait_to_be_fetched(
    page: Page, done: Recording, room: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    keys = [made(page, done)]
    monkeypatch.setattr(exports_module, "WAITING_MAX", 2)
    keys.append(made(page, done))
    answer = page.post(f"/api/recordings/{done.id}/exports", json={"format": "rrd"})
    assert answer.status_code == 409 and answer.json()["detail"].startswith("2 exports wait to be fetched")
    monkeypatch.setattr(exports_module, "WAITING_MAX", 3)
    monkeypatch.setattr(exports_module, "WAITING_BYTES", done.bytes)
    answer = page.post(f"/api/recordings/{done.id}/exports", json={"format": "rrd"})
    assert answer.status_code == 409 and f"the most is {done.bytes / 1e6:.1f} MB" in answer.json()["detail"]
    for key in keys:
        assert page.get(f"/api/exports/{key}").status_code == 200
    assert page.get(f"/api/exports/{made(page, done)}").status_code == 200
    wait_for(lambda: is_empty(room), "an empty folder")


def left_by_a_killed_server(room: Path, name: str = "killed") -> Path:
    """As its kernel leaves it: no one holds the lock any more."""
    folder = room / f"{scratch_module.PREFIX}{name}"
    folder.mkdir()
    for file in (scratch_module.LOCK, "run.csv"):
        (folder / file).write_text("")
    return folder


def test_the_start_sweeps_what_a_killed_server_left_and_nothing_of_another(
    room: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    left, others = left_by_a_killed_server(room), Scratch()
    foreign = room / "tendril-other"
    foreign.mkdir()
    started = TestServer(tmp_path_factory.mktemp("second"), "tcp/127.0.0.1:9")
    wait_for(lambda: not left.exists(), "the sweep")
    started.close()
    assert others.path.is_dir() and foreign.is_dir()
    others.remove()
    assert not others.path.exists()


def test_folders_without_a_lock_are_swept_only_when_old(room: Path) -> None:
    """As those of a version before; a young one may be about to get its lock."""
    young, old = (Path(tempfile.mkdtemp(prefix=scratch_module.PREFIX)) for _ in range(2))
    before = time.time() - scratch_module.UNLOCKED - 1.0
    os.utime(old, (before, before))
    sweep()
    assert young.is_dir() and not old.exists()


def test_a_folder_of_somebody_else_and_a_link_stay(room: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = room / "elsewhere"
    target.mkdir()
    (target / scratch_module.LOCK).write_text("")
    (room / f"{scratch_module.PREFIX}link").symlink_to(target)
    theirs = left_by_a_killed_server(room, "theirs")
    monkeypatch.setattr(scratch_module, "os", SimpleNamespace(geteuid=lambda: os.geteuid() + 1))
    sweep()
    assert theirs.is_dir()
    monkeypatch.undo()
    monkeypatch.setattr(tempfile, "tempdir", str(room))
    sweep()
    assert not theirs.exists() and (target / scratch_module.LOCK).exists()


def test_the_end_of_the_server_removes_what_is_left(room: Path) -> None:
    exports = Exports(Scheduler())
    file = exports.new("run.csv")
    with (file.scratch.path / scratch_module.LOCK).open() as lock, pytest.raises(BlockingIOError):
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    exports.close()
    assert is_empty(room)
