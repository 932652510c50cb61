"""The commands of docs/two-machines.md, as they stand there, with two state folders in place of two machines."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from controller.realtime.ring import remove_rings
from controller.realtime.settings import free_port
from server.app.ready import ServerReady
from tests.server.live_server import Page, wait_for

pytestmark = [
    pytest.mark.alone,
    pytest.mark.keyed("server", "controller", "recordings", "docs/two-machines.md"),
]

DOCUMENT = Path(__file__).parents[3] / "docs" / "two-machines.md"
RIG = f"two-{os.getpid()}"


def documented(command: str) -> list[str]:
    """The first line of the document that begins with `command`, as words."""
    (line, *_) = re.findall(rf"^{command} .*$", DOCUMENT.read_text(), re.MULTILINE)
    return shlex.split(line)


@contextmanager
def machine(folder: Path, words: list[str], **replaced: str) -> Iterator[subprocess.Popen[bytes]]:
    """`words` run as on a machine of its own: its home is `folder`, and what is `replaced` is its address."""
    folder.mkdir(exist_ok=True)
    home = {"HOME": str(folder), "XDG_STATE_HOME": str(folder / "state")}
    plain = {name: value for name, value in os.environ.items() if not name.startswith("TENDRIL_")}
    given = [replaced.get(word, word).replace("~", str(folder)) for word in words]
    command = [str(Path(sys.executable).parent / given[0]), *given[1:]]
    process = subprocess.Popen(command, env=plain | home)
    try:
        yield process
    finally:
        process.terminate()
        process.wait()


def test_the_documented_commands_join_two_machines(tmp_path: Path) -> None:
    here, there = tmp_path / "server", tmp_path / "rig"
    port = free_port("tcp/127.0.0.1:0").rsplit(":", 1)[1]
    names = {"twin": RIG, "tcp/0.0.0.0:7447": f"tcp/0.0.0.0:{port}", "tcp/RIG:7447": f"tcp/127.0.0.1:{port}"}
    start = [*documented("tendril rig"), "--loop-gap", "0.4", "--ready", str(tmp_path / "rig.json")]
    serve = [*documented("tendril serve"), "--port", "0", "--ready", str(tmp_path / "server.json")]
    with machine(there, start, **names) as rig:
        wait_for(lambda: (tmp_path / "rig.json").exists() or rig.poll() is not None, "the rig")
        _, _, source, target = documented("scp")
        (here / ".tendril").mkdir(parents=True)
        shutil.copy2(there / source.split(":")[1], target.replace("~", str(here)))
        with machine(here, serve, **names) as server:
            wait_for(lambda: (tmp_path / "server.json").exists() or server.poll() is not None, "the server")
            operate(ServerReady.model_validate_json((tmp_path / "server.json").read_bytes()).url)
    assert not list(here.rglob("*.ring"))
    remove_rings(RIG)


def operate(url: str) -> None:
    """Sign in, arm and stop through the server at `url`, which holds its token."""
    origin, token = url.split("/?token=")
    with Page(origin) as page:
        assert page.post("/api/session", json={"token": token}).status_code == 200
        assert page.post("/api/lease").status_code == 200
        health = wait_for(lambda: (found := page.get("/api/health").json())["rig_connected"] and found, "the rig")
        assert health["trouble"] == ""
        assert page.command("arm").json()["mode"] == 1
        assert page.command("e_stop").status_code == 200
