"""Many viewers: what they share, how many there may be, and how little one that reads nothing can hold."""

import contextlib
import json
import socket
import time
from collections.abc import Iterator

import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import ClientConnection

from server.app.services import Services
from server.live.hub import WAITING, Viewer
from server.live.messages import Status
from server.live.status import StatusView
from server.plots import feed
from server.plots.feed import Feed, Plots
from server.rig.history import History
from tests.server.live_server import Page, TestServer, wait_for
from tests.server.plots.test_history import ENERGY, ERROR, rows

pytestmark = [pytest.mark.alone, pytest.mark.keyed()]

EVENTS = 5000
LINE = "x" * 400


def test_viewers_who_lack_the_same_bins_share_one_message(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[int] = []
    encode = feed.encode_plot
    monkeypatch.setattr(feed, "encode_plot", lambda bins: (made.append(bins.first), encode(bins))[1])
    history = History(1000, 100)
    plots = Plots(history)
    feeds = [Feed(plots) for _ in range(50)]
    history.add(rows(0, 160))
    for number, each in enumerate(feeds):
        each.choose([ENERGY] if number % 2 else [ENERGY, ERROR], since=0.0)
        each.next()
    made.clear()
    for first in (160, 192):
        history.add(rows(first, 32))
        sent = [each.next() for each in feeds]
        assert sent[0] is sent[2] and sent[1] is sent[3] and sent[0] != sent[1]
    assert made == [10, 10, 12, 12], "two choices, two beats"


def test_a_status_is_made_for_operator_and_viewers_not_for_each(
    server: TestServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[str] = []
    status = StatusView.status
    monkeypatch.setattr(StatusView, "status", lambda view, who: (made.append(who.id), status(view, who))[1])
    operator, viewer = server.operator(), server.page().sign_in()
    with contextlib.ExitStack() as pages:
        operating = pages.enter_context(operator.live())
        watching = [pages.enter_context(viewer.live()) for _ in range(10)]
        every = (operating, *watching)
        before, made[:] = [statuses(page.texts) for page in every], []
        wait_for(lambda: all(statuses(p.texts) >= n + 3 for p, n in zip(every, before, strict=True)), "statuses")
        sent = sum(statuses(page.texts) for page in every) - sum(before)
        assert len(made) < sent / 2, f"{len(made)} made for {sent}"
        for page in every:
            last = [text for text in page.texts if text["type"] == "status"][-1]
            assert Status.model_validate(last).lease.mine is (page is operating)


def statuses(texts: list[dict[str, object]]) -> int:
    return sum(text["type"] == "status" for text in list(texts))


def test_one_page_more_than_allowed_is_refused_but_not_the_operators(server: TestServer) -> None:
    server.services.pages.seats = 2
    operator, viewer = server.operator(), server.page().sign_in()
    with viewer.live() as first, viewer.live():
        first.wait("hello")
        with pytest.raises(InvalidStatus) as refused:
            viewer.connect("/ws/live")
        answer = refused.value.response
        assert (answer.status_code, answer.headers["retry-after"]) == (503, "10")
        assert "2 pages are open" in json.loads(answer.body)["detail"]
        told = viewer.get("/api/live")
        assert (told.status_code, told.json()) == (503, json.loads(answer.body)), "as a browser is told"
        assert viewer.command("e_stop").status_code == 200, "it may stop all the same"
        with operator.live() as operating:
            operating.wait("hello")
    wait_for(lambda: viewer.get("/api/live").status_code == 204, "a free seat")
    with viewer.live() as again:
        again.wait("hello")


def test_a_viewer_that_reads_nothing_holds_no_more_than_its_share(server: TestServer) -> None:
    page = server.operator()
    with unread(page) as stuck:
        wait_for(lambda: server.services.pages.open, "the viewer")
        hold_up(server, stuck)
    wait_for(lambda: not server.services.pages.open, "the viewer to be forgotten")


def hold_up(server: TestServer, stuck: ClientConnection) -> None:
    [viewer] = server.services.pages.open
    stuck.send(json.dumps({"type": "plots", "channels": ["energy"], "since": None}))
    wait_for(lambda: still(viewer, server.services), "the viewer to be stuck")
    loop = viewer.wake._loop  # type: ignore[attr-defined]
    for number in range(EVENTS):
        loop.call_soon_threadsafe(server.services.events.add, f"{number} {LINE}")
    last = f"{EVENTS - 1} {LINE}"
    wait_for(lambda: viewer.outbox and last in viewer.outbox[-1], "the newest to be kept")
    assert len(viewer.outbox) == WAITING
    held = sum(len(text) for text in viewer.outbox)
    assert held < WAITING * (len(LINE) + 200)
    wait_for(lambda: still(viewer, server.services), "it is stuck all the same")
    stuck.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
    texts = []
    while not texts or last not in texts[-1]:
        message = stuck.recv(timeout=60)
        texts += [message] if isinstance(message, str) and LINE in message else []
    assert len(texts) < EVENTS / 2, "what waited in the kernel and in the server is all that was kept"


@contextlib.contextmanager
def unread(page: Page) -> Iterator[ClientConnection]:
    """A live socket of which hardly anything fits into its own machine."""
    found = page.connect("/ws/live", max_queue=1)
    found.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    try:
        yield found
    finally:
        found.socket.shutdown(socket.SHUT_RDWR)
        found.close()


def still(viewer: Viewer, services: Services) -> bool:
    """Whether nothing was sent for half a second in which there was more to send."""
    cursor, count = viewer.cursor, services.history.count
    time.sleep(0.5)
    return bool(viewer.cursor == cursor and services.history.count > count)
