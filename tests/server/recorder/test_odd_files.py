"""Nothing that lies in a folder stops a start or makes an answer fail, and nothing outside is read or served."""

import json
import logging
import os
import random
import shutil
import subprocess
import sys
import threading
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
from typer.testing import CliRunner

from controller.schema.parameters import Settings
from recordings.store.store import Store
from recordings.write.writer import Recorder
from server.app.app import openapi_schema
from server.app.ready import ServerReady
from server.cli.recordings import app as recordings_cli
from tests.recordings.synthetic import rig_info, telemetry_rows
from tests.server.live_server import Page, RigProcess, TestServer, free_environment, key_file, wait_for

pytestmark = [pytest.mark.process, pytest.mark.keyed()]

SECRET = b"of someone else, far outside"
ID = "20260101-000000"
STATE = (
    "secrets.json",
    "settings-test.json",
    "events-test.jsonl",
    "events-test.jsonl.old",
    "audit-test.jsonl",
    "runs-test.json",
    "actuator-test.json",
    "gains.json",
    "drawings",
    "layouts",
    "alarms",
    "drawings/one.json",
    "drawings/two.json",
    "layouts/one.json",
    "alarms/one.json",
)
RECORDINGS = (
    *(f"{ID}-{name}.{kind}" for name in ("a", "b", "c", "d") for kind in ("rrd", "json")),
    f".{ID}-a.quick",
    f".draft-{ID}-a",
    ".index.json",
    ".sidecars.lock",
    "strange.rrd",
    "strange.json",
    f"{ID}-\udcff.json",
)
GETS = [path for path, methods in openapi_schema()["paths"].items() if "get" in methods]


def spoil(path: Path, chance: random.Random, outside: Path, good: bytes) -> None:
    """Put anything at all at `path`."""
    kinds: list[Callable[[], object]] = [
        lambda: None,
        lambda: path.write_bytes(b""),
        lambda: path.write_bytes(good[: chance.randrange(len(good))]),
        lambda: path.write_bytes(chance.randbytes(chance.randrange(1, 9000))),
        lambda: path.write_bytes(bytes(chance.randrange(1, 9000))),
        lambda: path.write_bytes(chance.choice([b"[]", b"{}", b"null", b"[" * 5000, b'{"id": 1e999}'])),
        lambda: path.mkdir(exist_ok=True),
        lambda: os.mkfifo(path),
        lambda: path.symlink_to(outside),
        lambda: path.symlink_to(path.name),
        lambda: path.symlink_to("nothing"),
        lambda: path.symlink_to(path.parent),
    ]
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        chance.choice(kinds)()
    except OSError:  # what is above it is no folder, or it is one already
        pass


@contextmanager
def served(rig: RigProcess, folder: Path) -> Iterator[TestServer]:
    free_environment()
    found = TestServer(folder, rig.endpoint, rate_factor=1e6)
    try:
        yield found
    finally:
        found.close()


def ask_everything(page: Page, ids: list[str]) -> dict[str, tuple[int, bytes]]:
    """Every answer to a GET by its address; each id where an id is asked for."""
    found = {}
    for path in GETS:
        for value in ids if "{" in path else [""]:
            address = path.replace("{id}", value).replace("{name}", "one").replace("{seat}", "seat")
            query = (
                {"format": "rrd", "token": "x", "start": 0, "stop": 1, "signals": "u.0"} if "{id}" not in path else {}
            )
            query = {"format": "csv"} if path.endswith("/export") else query
            answer = page.get(address, params=query)
            found[address] = answer.status_code, answer.content
    return found


def require_answers(found: dict[str, tuple[int, bytes]], also: tuple[str, ...] = ()) -> None:
    bad = {
        address: (code, text[:300])
        for address, (code, text) in found.items()
        if code >= 500 and not (code == 503 and address in ("/healthz", *also))
    }
    assert not bad, bad
    assert not [address for address, (_, text) in found.items() if SECRET in text]


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(1, 20))])
def test_folders_full_of_anything_stop_no_start_and_no_answer(
    seed: int, shared_rig: RigProcess, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    chance, outside = random.Random(seed), tmp_path / "outside"
    outside.write_bytes(SECRET)
    good = json.dumps({"token": "a", "viewer_token": "b", "key": "c", "K_P": [0.1, 0.1]}).encode()
    for folder, names in (("state", STATE), ("recordings", RECORDINGS)):
        for name in names:
            spoil(tmp_path / folder / name, chance, outside, good)
    caplog.set_level(logging.WARNING)
    with served(shared_rig, tmp_path) as server:
        page = server.operator()
        ids = [f"{ID}-{name}" for name in "abcd"]
        for _ in range(2):
            require_answers(ask_everything(page, ids))
        for method, path, body in (
            ("PATCH", f"/api/recordings/{ids[0]}", {"name": "x"}),
            ("DELETE", f"/api/recordings/{ids[1]}", None),
            ("PUT", "/api/gains/mine", None),
            ("PUT", "/api/alarms", page.get("/api/alarms").json()),
            ("DELETE", "/api/alarms", None),
            ("DELETE", "/api/drawings/one", None),
        ):
            answer = page.request(method, path, json=body)
            assert answer.status_code < 500, (path, answer.text)
    lines = [record.getMessage() for record in caplog.records if str(tmp_path) in record.getMessage()]
    assert [line for line, times in Counter(lines).items() if times > 1] == [], "each problem is told once"
    assert not [record for record in caplog.records if record.exc_info], "and without a traceback"
    assert outside.read_bytes() == SECRET
    runner = CliRunner()
    for arguments in (["ls"], ["ls", "--json"], ["show", ids[0]], ["export", ids[0], "--out", str(tmp_path / "x")]):
        done = runner.invoke(recordings_cli, [*arguments, "--folder", str(tmp_path / "recordings")])
        assert done.exception is None or type(done.exception).__name__ in ("SystemExit", "RecordingError"), done
    assert not (tmp_path / "x").exists() or SECRET not in (tmp_path / "x").read_bytes()


def test_a_link_to_a_recording_outside_is_neither_served_nor_exported_nor_deleted(
    shared_rig: RigProcess, tmp_path: Path
) -> None:
    (tmp_path / "recordings").mkdir()
    recorder = Recorder(tmp_path / "elsewhere")
    recorder.start("private", rig_info(), Settings())
    recorder.rows(telemetry_rows(200))
    id = recorder.stop().id
    recorder.close()
    for kind in ("rrd", "json"):
        (tmp_path / "recordings" / f"{id}.{kind}").symlink_to(tmp_path / "elsewhere" / f"{id}.{kind}")
    shutil.copy(tmp_path / "elsewhere" / f"{id}.json", tmp_path / "recordings" / "x")
    with served(shared_rig, tmp_path) as server:
        page = server.operator()
        assert page.get("/api/recordings").json() == []
        for what in ("", ".rrd", "/export?format=csv", "/quick", "/signals", "/path", "/metrics"):
            answer = page.get(f"/api/recordings/{id}{what}")
            assert answer.status_code in (404, 422), (what, answer.status_code, answer.text)
        assert page.delete(f"/api/recordings/{id}").status_code == 404
    assert (tmp_path / "elsewhere" / f"{id}.rrd").exists()
    assert Store(tmp_path / "elsewhere").find(id).complete


def replaced(folder: Path) -> None:
    """Put a file in the place of `folder`, into which a server may be writing: it may be made again meanwhile."""
    while not folder.is_file():
        shutil.rmtree(folder, ignore_errors=True)
        with suppress(IsADirectoryError):
            folder.write_text("a file where the folder was")


def test_folders_that_are_deleted_under_a_running_server_are_answered_in_a_sentence(
    shared_rig: RigProcess, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with served(shared_rig, tmp_path) as server:
        page = server.operator()
        assert page.get("/api/recordings").json() == []
        for folder in ("recordings", "state"):
            replaced(tmp_path / folder)
        for _ in range(3):
            require_answers(ask_everything(page, [f"{ID}-a"]))
        refused = page.post("/api/recordings", json={"name": "no"})
        assert (refused.status_code, "nothing can be written into" in refused.text) == (409, True)
    told = [record for record in caplog.records if "cannot be listed" in record.getMessage()]
    assert len(told) == 1


def test_read_only_folders_let_the_server_start_and_refuse_a_recording(shared_rig: RigProcess, tmp_path: Path) -> None:
    """A server of its own that may not write, root or not: without the right to pass over a folder's mode."""
    free_environment()
    state, recordings, ready = tmp_path / "state", tmp_path / "recordings", tmp_path / "ready" / "server.json"
    for folder in (state, recordings, ready.parent):
        folder.mkdir()
    Recorder(recordings).close()
    given = {"port": 0, "endpoint": shared_rig.endpoint, "rig": "test", "key_file": key_file(tmp_path)}
    given |= {"state": state, "recordings": recordings, "light_scene": 1, "token": "correct horse"}
    environment = os.environ | {f"TENDRIL_{name.upper()}": str(value) for name, value in given.items()}
    drop = ["setpriv", "--bounding-set", "-dac_override,-dac_read_search"] if os.geteuid() == 0 else []
    for folder in (state, recordings):
        folder.chmod(0o500)
    output = (tmp_path / "log").open("wb")
    process = subprocess.Popen(
        [*drop, sys.executable, "-m", "server.app", str(ready)], env=environment, stdout=output, stderr=output
    )
    try:
        wait_for(lambda: ready.exists() or process.poll() is not None, "the server")
        url = ServerReady.model_validate_json(ready.read_bytes()).url.split("/?")[0]
        with Page(url) as page:
            page.sign_in("correct horse").operate()
            wait_for(lambda: page.get("/api/health").json()["rig_connected"], "the rig")
            require_answers(ask_everything(page, [f"{ID}-a"]), ("/rerun/",))
            page.operate()  # a lease lapses on a busy machine
            refused = page.post("/api/recordings", json={"name": "no"})
            assert (refused.status_code, "nothing can be written into" in refused.text) == (409, True)
            assert page.patch("/api/settings", json={"changes": {"K_P": [0.1, 0.1]}}).status_code == 200
            assert page.put("/api/gains/mine").status_code == 503
    finally:
        process.terminate()
        process.wait()
        output.close()
        for folder in (state, recordings):
            folder.chmod(0o700)
    text = (tmp_path / "log").read_text()
    assert "tokens will not outlive this server" in text and "Traceback" not in text, text


def test_a_start_does_not_wait_for_a_folder_that_does_not_answer(
    shared_rig: RigProcess, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A network folder that hangs: no test can make a real one, so every call of the system on it waits here."""
    answers, waiting = threading.Event(), threading.Event()
    folder = str(tmp_path / "recordings")

    def hung(name: str) -> None:
        real = getattr(os, name)

        def call(path: object, *more: object, **named: object) -> object:
            if isinstance(path, str | os.PathLike) and os.fspath(path).startswith(folder):
                waiting.set()
                answers.wait(60.0)
            return real(path, *more, **named)

        monkeypatch.setattr(os, name, call)

    for name in ("scandir", "stat", "lstat", "open", "mkdir", "statvfs", "listdir"):
        hung(name)
    try:
        with served(shared_rig, tmp_path) as server:
            page = server.operator()
            assert waiting.wait(60.0), "someone looks into it by now"
            askers = [threading.Thread(target=page.get, args=("/api/recordings",)) for _ in range(20)]
            for asker in askers:
                asker.start()
            assert page.get("/api/settings").status_code == 200
            assert page.put("/api/alarms", json=page.get("/api/alarms").json()).status_code == 200
            assert page.command("arm").status_code == 200
            assert page.command("e_stop").status_code == 200
            assert page.command("clear").status_code == 200
            assert not answers.is_set()
            answers.set()
            for asker in askers:
                asker.join()
            assert page.get("/api/recordings").json() == []
    finally:
        answers.set()
