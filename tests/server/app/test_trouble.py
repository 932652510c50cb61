"""A rig that takes nothing from this server: everyone who looks is told why, and what can still be done works."""

import subprocess
import sys
from pathlib import Path

import pytest

from controller.errors import KeyRefused
from controller.link import version
from controller.schema.modes import Mode
from controller.system.keys import made_key
from server.app.services import Services
from tests.server.live_server import RigProcess, TestServer, free_environment, key_file, wait_for

pytestmark = [pytest.mark.alone, pytest.mark.keyed()]

TENDRIL = Path(sys.executable).parent / "tendril"


def logged(server: TestServer, text: str) -> bool:
    """Whether the page's log has an error with this text, soon."""
    return wait_for(lambda: any(e.level == "error" and text in e.text for e in server.services.events.recent), text)


def mode_seen_by(server: TestServer) -> int | None:
    """The rig's mode in the newest row that this server has."""
    newest = server.services.history.newest
    return None if newest is None else int(newest["mode"][0])


def test_a_second_server_says_who_commands_and_can_only_stop(
    server: TestServer, shared_rig: RigProcess, tmp_path: Path
) -> None:
    first = server.operator()
    second = TestServer(tmp_path, shared_rig.endpoint)
    try:
        page = second.page().sign_in().operate()
        with page.live() as live:
            told = live.wait("status", lambda m: m["health"]["trouble"])
            assert "commands this rig since" in told["health"]["trouble"]
            assert told["health"]["rig_connected"]
            assert logged(second, "commands this rig since")
            refused = page.command("arm")
            assert refused.status_code == 409
            assert "the server on" in refused.json()["detail"]
            assert page.command("e_stop").json()["mode"] == Mode.E_STOP
            assert page.get("/api/health").json()["trouble"] == told["health"]["trouble"]
            wait_for(lambda: mode_seen_by(server) == Mode.E_STOP, "the first server to see it")
            assert first.command("clear").status_code == 200
            server.close()
            live.texts.clear()
            live.wait("status", lambda m: not m["health"]["trouble"])
            armed = page.command("arm")
            assert armed.status_code == 200, armed.text
            assert page.command("e_stop").status_code == page.command("clear").status_code == 200
    finally:
        second.close()


def test_another_version_is_named_to_everyone_who_looks(
    shared_rig: RigProcess, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    free_environment()
    monkeypatch.setattr(version, "LAYOUT", "feedfacefeedface")
    server = TestServer(tmp_path, shared_rig.endpoint)
    try:
        page = server.page().sign_in().operate()
        with page.live() as live:
            trouble = live.wait("status", lambda m: m["health"]["trouble"])["health"]["trouble"]
            assert logged(server, "run the same version")
        assert trouble.startswith(f"rig 'test' is Tendril {version.OURS} with record layout ")
        assert f"this server is Tendril {version.OURS} with feedfacefeedface: run the same version" in trouble
        assert page.get("/api/health").json()["trouble"] == trouble
        assert page.command("e_stop").status_code == 503
    finally:
        server.close()


def test_a_server_with_another_key_is_kept_out_and_says_what_it_needs(shared_rig: RigProcess, tmp_path: Path) -> None:
    free_environment()
    made_key(tmp_path / "other.key")
    other = TestServer(tmp_path, shared_rig.endpoint, tmp_path / "other.key")
    try:
        page = other.page().sign_in().operate()
        trouble = wait_for(lambda: page.get("/api/health").json()["trouble"], "the refusal")
        assert "this server's key is not the rig's" in trouble and "--key-file" in trouble
        assert other.services.history.newest is None
        assert page.command("e_stop").status_code == 503
    finally:
        other.close()


def test_a_server_without_a_usable_key_does_not_start(server: TestServer, tmp_path: Path) -> None:
    path = key_file(tmp_path)
    path.chmod(0o644)
    with pytest.raises(KeyRefused, match="mode 0644"):
        Services(server.settings.model_copy(update={"key_file": path}))
    done = subprocess.run([TENDRIL, "serve", "--key-file", tmp_path / "no.key"], capture_output=True, text=True)
    assert (done.returncode, len(done.stderr.splitlines())) == (1, 1)
    assert "no.key does not exist: copy it from the rig's machine" in done.stderr
