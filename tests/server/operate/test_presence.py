"""Signs of an open page on a socket of their own: whose they are, what they keep going, and what ends them."""

import json
from collections.abc import Iterator

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection

from controller.schema.modes import Cause, Mode
from tests.server.live_server import Live, Page, TestServer, wait_for


class Worker:
    """The presence socket of one page."""

    def __init__(self, page: Page, live: Live) -> None:
        self.name = live.wait("hello")["page"]
        self.socket: ClientConnection = page.connect(f"/ws/presence/{self.name}")
        self.n = 0

    def sign(self) -> None:
        """Give one sign, and wait until it was heard."""
        self.n += 1
        self.socket.send(json.dumps({"type": "presence", "n": self.n}))
        assert json.loads(self.socket.recv(timeout=60)) == {"type": "heard", "n": self.n}

    def is_over(self) -> bool:
        """Whether the server ends it."""
        with pytest.raises(ConnectionClosed) as closed:
            while True:
                self.socket.recv(timeout=60)
        return closed.value.rcvd is not None and closed.value.rcvd.code == 1008


@pytest.fixture
def page(server: TestServer) -> Page:
    """An operator's, whose rig holds."""
    found = server.operator()
    assert found.command("arm").status_code == 200
    return found


@pytest.fixture
def live(page: Page) -> Iterator[Live]:
    """Its live socket, which says nothing of presence itself."""
    with page.live() as found:
        yield found


def press(live: Live) -> None:
    """A fresh press on the target."""
    live.send(type="target", id=1, x=0.2, y=0.05, start=True)
    assert live.wait("reply", lambda m: m["id"] == 1)["reply"]["accepted"]


def follow(live: Live) -> None:
    """Press, and once more wherever a machine that paused made the rig hold again, until it follows."""

    def followed() -> bool:
        mode = live.frames[-1]["mode"] if live.frames else None
        if mode == Mode.HOLD:
            press(live)
        return mode == Mode.FOLLOW

    wait_for(followed, "FOLLOW")


def test_signs_of_the_worker_keep_a_motion_going_and_without_them_it_holds(page: Page, live: Live) -> None:
    worker = Worker(page, live)
    worker.sign()
    press(live)
    first = int(live.wait_mode(Mode.FOLLOW)["tick"])

    def went_on() -> bool:
        worker.sign()
        return int(live.frames[-1]["tick"]) > first + 4000  # twice the rig's patience

    wait_for(went_on, "four seconds of rows")
    assert live.frames[-1]["mode"] == Mode.FOLLOW
    assert live.wait_mode(Mode.HOLD)["cause"] == Cause.OPERATOR_LOST, "though both sockets are open"


def test_signs_are_worth_nothing_once_the_pages_live_socket_is_closed(page: Page, server: TestServer) -> None:
    viewer = server.page().sign_in()
    with viewer.live() as watching, page.live() as live:
        worker = Worker(page, live)
        worker.sign()
        press(live)
        watching.wait_mode(Mode.FOLLOW)
        live.close()
        assert worker.is_over()
        assert watching.wait_mode(Mode.HOLD)["cause"] == Cause.OPERATOR_LOST


def test_a_worker_of_another_session_or_page_gets_no_socket(page: Page, live: Live, server: TestServer) -> None:
    name = live.wait("hello")["page"]
    other, stranger = server.page().sign_in(), server.page()
    for who, path, status in [(other, name, 404), (page, "x", 404), (page, name[:-1], 404), (stranger, name, 401)]:
        with pytest.raises(InvalidStatus) as refused:
            who.connect(f"/ws/presence/{path}")
        assert refused.value.response.status_code == status
    with pytest.raises(InvalidStatus) as foreign:
        page.connect(f"/ws/presence/{name}", headers={"origin": "http://evil.example"})
    assert foreign.value.response.status_code == 403


def test_a_page_has_one_presence_socket_the_newest(page: Page, live: Live) -> None:
    first = Worker(page, live)
    first.sign()
    second = Worker(page, live)
    assert first.is_over()
    second.n = first.n
    second.sign()


def test_signs_keep_nothing_going_that_the_next_operator_began(page: Page, live: Live, server: TestServer) -> None:
    worker, other = Worker(page, live), server.page().sign_in()
    worker.sign()
    assert page.delete("/api/lease").status_code == 200
    other.operate()
    with other.live() as theirs:
        theirs.operate()
        follow(theirs)
        theirs.operate(False)

        def held() -> bool:
            worker.sign()
            return theirs.frames[-1]["mode"] == Mode.HOLD

        wait_for(held, "HOLD")
        assert theirs.frames[-1]["cause"] == Cause.OPERATOR_LOST


@pytest.mark.parametrize("text", ["", "[]", '{"type": "target", "id": 1, "x": 0, "y": 0}', "x" * 65, b"\x01"])
def test_anything_else_ends_the_socket_and_is_in_the_log(
    text: str | bytes, page: Page, live: Live, server: TestServer
) -> None:
    worker = Worker(page, live)
    worker.socket.send(text)
    assert worker.is_over()
    live.wait("event", lambda m: "presence refused" in m["text"])


def test_a_drag_whose_ground_moved_holds_behind_its_targets(page: Page, live: Live) -> None:
    worker = Worker(page, live)
    worker.sign()
    press(live)
    live.wait_mode(Mode.FOLLOW)
    live.send(type="target", id=2, x=0.2, y=0.06)
    live.send(type="release", hold=True)
    assert live.wait_mode(Mode.HOLD)["cause"] == Cause.OPERATOR
    live.send(type="target", id=3, x=0.2, y=0.07)
    live.wait("reply", lambda m: m["id"] == 3)
    assert live.frames[-1]["mode"] == Mode.HOLD
