"""The examples, and pages with requests, against a real rig and server; the last run's recording is their ID."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection

from controller.system.origin import ROOT
from tests.docs.blocks import EXAMPLES, NOT_HERE, PAGES, Shell, commands, name
from tests.docs.test_commands import HERE
from tests.server.live_server import TOKEN, RigProcess, TestServer, free_environment

pytestmark = [
    pytest.mark.alone,
    pytest.mark.keyed("docs", "server", "tests/docs/*.py", "tests/server/live_server.py", imports=False),
]

PROGRAMS = [command for command in commands(EXAMPLES / "README.md") if "again" not in command]
WATCH, FOLLOW, EXPORT, READ = PROGRAMS


class Served:
    """A server with a rig, and a shell beside it in which each command runs once; ID is that of the first run."""

    def __init__(self, server: TestServer, folder: Path, recordings: Path) -> None:
        self.server = server
        self._places = {"http://127.0.0.1:8321": server.url, "TOKEN": TOKEN}
        self._shell = Shell(folder, self._places, TENDRIL_RECORDINGS=str(recordings))
        self._said: dict[str, str] = {}

    def run(self, command: str) -> str:
        """What it printed."""
        if re.search(r"\bID\b", command) and "ID" not in self._places:
            self._places["ID"] = self.run(FOLLOW).split()[-1]
        if command not in self._said:
            self._said[command] = self._shell.run(command)
        return self._said[command]


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    free_environment()
    rig = RigProcess(tmp_path_factory.mktemp("rig"))
    kept = tmp_path_factory.mktemp("server")
    server = TestServer(kept, rig.endpoint, rate_factor=100.0)
    server.operator().delete("/api/lease")  # the rig is there
    yield Served(server, tmp_path_factory.mktemp("shell"), kept / "recordings")
    server.close()
    rig.stop()


def test_a_path_is_uploaded_followed_and_measured(served: Served) -> None:
    said = served.run(FOLLOW).splitlines()
    assert [one for one in said if one in ("approach", "running", "done")] == ["approach", "running", "done"]
    assert (found := re.fullmatch(r"rmse ([\d.]+) mm, recording (\S+)", said[-1])), said
    assert 0.0 < float(found[1]) < 30.0
    page = served.server.page().sign_in()
    assert page.get(f"/api/recordings/{found[2]}").json()["name"].startswith("spiral")
    assert page.get("/api/drawings/spiral").json()["timing"] == {"kind": "given"}
    assert page.get("/api/session").json()["lease"]["held"] is False


def test_the_live_socket_is_decoded(served: Served) -> None:
    said = served.run(WATCH).splitlines()
    tips = [re.fullmatch(r"t = ([\d.]+) s  tip = \((\S+), (\S+)\) mm  mode (\d)", one) for one in said[1:-1]]
    assert len(tips) >= 3 and all(tips)
    times = [float(tip[1]) for tip in tips if tip]
    assert times == sorted(times) and times[0] < times[-1]
    assert all(0.0 < float(tip[2]) < 300.0 and abs(float(tip[3])) < 300.0 for tip in tips if tip)
    assert (last := re.fullmatch(r"(\d+) frames; the largest error was ([\d.]+) mm", said[-1])), said
    assert int(last[1]) > len(tips)


def test_a_recording_is_read_into_numpy(served: Served) -> None:
    served.run(EXPORT)
    said = served.run(READ)
    assert (found := re.search(r"(\d+) ticks, ([\d.]+) s", said))
    assert float(found[2]) > 8.0 and int(found[1]) > 0.9e3 * float(found[2])


@pytest.mark.parametrize("page", [page for page in PAGES if page not in HERE], ids=name)
def test_the_commands_of_a_page_run(page: Path, served: Served) -> None:
    for command in commands(page):
        if command not in NOT_HERE:
            served.run(command)


def closed_with(socket: ClientConnection) -> str:
    """The line of docs/live.md on the code with which the server closes this socket."""
    with pytest.raises(ConnectionClosed) as closed:
        while True:
            socket.recv()
    assert closed.value.rcvd
    lines = (ROOT / "docs" / "live.md").read_text().splitlines()
    return next(line for line in lines if line.startswith(f"| {closed.value.rcvd.code} |"))


def test_a_message_that_is_too_long_closes_the_socket_as_the_page_says(served: Served) -> None:
    socket = served.server.page().sign_in().connect("/ws/live")
    socket.send("x" * ((1 << 20) + 1))
    assert "over 1 MiB" in closed_with(socket)


def test_a_server_that_ends_closes_the_socket_as_the_page_says(tmp_path: Path) -> None:
    server = TestServer(tmp_path, "tcp/127.0.0.1:1")
    socket = server.page().sign_in().connect("/ws/live")
    server.close()
    assert "shuts down" in closed_with(socket)
