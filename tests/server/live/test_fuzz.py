"""Ten thousand messages that no page would send: nothing crashes or restarts, nothing moves, others are served."""

import logging
from collections.abc import Callable, Iterator
from pathlib import Path
from random import Random

import pytest
import viser
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection

from controller.schema.modes import Mode
from tests.server.fuzz import live_message, viser_message
from tests.server.live_server import Live, Page, RigProcess, TestServer, free_environment, wait_for

pytestmark = pytest.mark.alone

SHORT, LONG = 1000, 5000
"""Messages on each of the two sockets."""
Make = Callable[[Random], tuple[bytes, bool]]
VERSION = f"viser-v{viser.__version__}"


@pytest.fixture
def unlimited(shared_rig: RigProcess, tmp_path: Path) -> Iterator[TestServer]:
    """A server that hears everything: rates have tests of their own."""
    free_environment()
    found = TestServer(tmp_path, shared_rig.endpoint, rate_factor=1e6)
    yield found
    found.close()


@pytest.mark.parametrize("count", [SHORT, pytest.param(LONG, marks=[pytest.mark.long, pytest.mark.timeout(3000)])])
@pytest.mark.parametrize("holds_lease", [False, True], ids=["viewer", "operator"])
def test_whatever_comes_on_a_socket_the_loop_and_the_others_go_on(
    holds_lease: bool, count: int, unlimited: TestServer, caplog: pytest.LogCaptureFixture
) -> None:
    """A viewer's against an arm that is held, and the operator's own against one that is vented."""
    server, operator = unlimited, unlimited.operator()
    page = operator if holds_lease else server.page().sign_in()
    mode = Mode.VENTED if holds_lease else Mode.HOLD
    with server.page().sign_in().live() as watcher:
        if not holds_lease:
            assert operator.command("arm").status_code == 200
        boot, first = server.services.rig.boot(), watcher.wait_mode(mode)["tick"]
        begin = len(watcher.frames) - 1
        with caplog.at_level(logging.ERROR):
            assert _fuzz(page, "/ws/live", live_message, count // 2) > 0
            assert _fuzz(page, "/viser", viser_message, count // 2) > 0
        _still_served(watcher)
        assert {Mode(frame["mode"]) for frame in watcher.frames[begin:]} == {mode}
        last = watcher.frames[-1]
        wait_for(lambda: watcher.frames[-1]["tick"] > last["tick"] > first, "more ticks")
        assert server.services.rig.boot() == boot
        assert not [record.getMessage() for record in caplog.records if record.name != "websockets.client"]
    wait_for(lambda: not server.services.pages.open, "the end of every viewer")
    assert operator.command("e_stop").status_code == 200


def _fuzz(page: Page, path: str, make: Make, count: int) -> int:
    """Send that many messages, on another socket where one was closed; the bytes sent."""
    random, sent = Random(f"{path} {count}"), 0
    socket = _connect(page, path)
    for _ in range(count):
        data, text = make(random)
        sent += len(data)
        try:
            socket.send(data, text=text)
            _drop_what_came(socket)
        except ConnectionClosed:
            socket = _connect(page, path)
    socket.close()
    return sent


def _connect(page: Page, path: str) -> ClientConnection:
    return page.connect(path, close_timeout=1, **({"subprotocols": [VERSION]} if path == "/viser" else {}))


def _drop_what_came(socket: ClientConnection) -> None:
    """Read what is there: a reader that stops is another test's."""
    try:
        while True:
            socket.recv(timeout=0)
    except TimeoutError:
        pass


def _still_served(watcher: Live) -> None:
    watcher.send(type="ping", t=77.0)
    watcher.wait("pong", lambda message: message["t"] == 77.0)
    seen = len(watcher.frames)
    wait_for(lambda: len(watcher.frames) > seen + 20, "frames")
