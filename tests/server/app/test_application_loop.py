"""The application's own loop: what crosses to it arrives whole and in order, and while it hangs an E-STOP passes."""

import asyncio
import contextlib
import threading
from collections.abc import Awaitable, Callable, Iterator

import httpx
import pytest
from starlette.types import Message, Receive, Scope, Send
from websockets.exceptions import ConnectionClosed

from controller.schema.modes import Mode
from server.app.application_loop import IN_FLIGHT_MAX, ApplicationLoop
from server.http.connections import UNHEARD_MAX, Socket
from server.live.socket_handler import MESSAGE_MAX_CHARS
from tests.server.live_server import VIEWER_TOKEN, Live, Page, TestServer
from tests.waiting import WAIT_MAX_S, wait_for

SOCKET: Scope = {"type": "websocket", "path": "/"}


@contextlib.contextmanager
def hanging(server: TestServer) -> Iterator[None]:
    """The application's loop stands still for as long as this lasts."""
    stuck, over = threading.Event(), threading.Event()

    def hang() -> None:
        stuck.set()
        over.wait(8.0)  # or the watchdog's 10 s are over

    server.services.scheduler.soon(hang)
    assert stuck.wait(WAIT_MAX_S)
    try:
        yield
        assert not over.is_set()
    finally:
        over.set()


def newest_mode(server: TestServer) -> Mode:
    """As the link's own thread has it: nothing of it comes from the application's loop."""
    newest = server.services.history.newest
    return Mode.VENTED if newest is None else Mode(int(newest[0]["mode"]))


@pytest.fixture
def held(server: TestServer) -> Page:
    """A rig that holds, and who operates it."""
    page = server.operator()
    assert page.command("arm").status_code == 200
    return page


def test_while_the_application_hangs_a_viewer_stops_by_http_and_is_answered(held: Page, server: TestServer) -> None:
    viewer = server.page().sign_in(VIEWER_TOKEN)
    with hanging(server):
        with pytest.raises(httpx.ReadTimeout):
            viewer.get("/api/health", timeout=0.3)
        answer = viewer.command("e_stop")
        assert (answer.status_code, answer.json()["mode"]) == (200, Mode.E_STOP)
        assert held.command("arm").status_code == 409, "and the rig's word reaches who operates"
    wait_for(lambda: any("e-stop" in event.text for event in server.services.events.recent), "its line in the log")


def test_a_stop_by_the_socket_passes_behind_what_the_hanging_application_has_not_heard(
    held: Page, server: TestServer
) -> None:
    with held.live() as live:
        live.wait("status")
        with hanging(server):
            for n in range(500):
                live.send(type="target", id=n, x=0.2, y=0.0, start=False)
            live.send(type="e_stop", n=3)
            wait_for(lambda: newest_mode(server) == Mode.E_STOP, "the rig's E-STOP")
        assert live.wait("reply", lambda m: m.get("n") == 3)["reply"]["accepted"]


def test_what_a_socket_sends_to_a_hanging_application_is_bounded(
    server: TestServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    heard: list[int] = []
    passed_on = Socket._pass_on
    monkeypatch.setattr(
        Socket,
        "_pass_on",
        lambda self: (heard.append(sum(map(len, self.frames))), passed_on(self)),  # type: ignore[func-returns-value]
    )
    with server.page().sign_in().live() as live:
        live.wait("status")
        with hanging(server):
            sending = threading.Thread(target=_flood, args=(live,), daemon=True)
            sending.start()
            sending.join(2.0)
            assert sending.is_alive(), "the network takes no more of it"
            assert sum(heard) <= UNHEARD_MAX + 2 * MESSAGE_MAX_CHARS, "one taken and one on its way"
        sending.join(WAIT_MAX_S)


def _flood(live: Live) -> None:
    """16 MB: more than any buffer on the way takes."""
    with contextlib.suppress(ConnectionClosed):
        for _ in range(4000):
            live.socket.send("x" * 4000)


class Ends:
    """The network's end of one socket."""

    def __init__(self, comes: list[Message]) -> None:
        self.coming: asyncio.Queue[Message] = asyncio.Queue()
        for message in comes:
            self.coming.put_nowait(message)
        self.sent: list[Message] = []
        self.may_send = asyncio.Event()
        self.may_send.set()

    async def receive(self) -> Message:
        return await self.coming.get()

    async def send(self, message: Message) -> None:
        await self.may_send.wait()
        if message.get("text") == "fails":
            raise OSError("gone")
        self.sent.append(message)


def serve(
    app: Callable[[Scope, Receive, Send], Awaitable[None]], use: Callable[[ApplicationLoop], Awaitable[None]]
) -> None:
    """Run `use` in an event loop of its own beside the application's."""
    application = ApplicationLoop(app, frozenset({"/here"}))
    application.run(lambda: asyncio.run(asyncio.wait_for(use(application), WAIT_MAX_S)))


def text(number: int) -> Message:
    return {"type": "websocket.send", "text": str(number)}


def test_what_is_received_and_sent_arrives_in_order_in_the_loop_it_belongs_to() -> None:
    threads: set[int] = set()
    application_thread = threading.get_ident()

    async def app(scope: Scope, receive: Receive, send: Send) -> None:
        threads.add(threading.get_ident())
        while (message := await receive())["type"] != "websocket.disconnect":
            await send(message)

    async def use(application: ApplicationLoop) -> None:
        said = [text(n) for n in range(1000)]
        ends = Ends([*said, {"type": "websocket.disconnect"}])
        await application(SOCKET, ends.receive, ends.send)
        assert ends.sent == said
        assert threads == {application_thread}
        assert threading.get_ident() not in threads

    serve(app, use)


def test_a_path_that_must_not_wait_is_answered_in_the_loop_that_calls() -> None:
    threads: list[int] = []

    async def app(scope: Scope, receive: Receive, send: Send) -> None:
        threads.append(threading.get_ident())

    async def use(application: ApplicationLoop) -> None:
        ends = Ends([])
        await application({"type": "http", "path": "/here"}, ends.receive, ends.send)
        assert threads == [threading.get_ident()]

    serve(app, use)


def test_a_slow_page_holds_up_who_sends_to_it_and_loses_nothing() -> None:
    given = 0

    async def app(scope: Scope, receive: Receive, send: Send) -> None:
        nonlocal given
        for n in range(50):
            await send(text(n))
            given += 1

    async def use(application: ApplicationLoop) -> None:
        ends = Ends([])
        ends.may_send.clear()
        served = asyncio.create_task(application(SOCKET, ends.receive, ends.send))
        while given < IN_FLIGHT_MAX:
            await asyncio.sleep(0.001)
        await asyncio.sleep(0.1)
        assert given == IN_FLIGHT_MAX
        ends.may_send.set()
        await served
        assert ends.sent == [text(n) for n in range(50)]

    serve(app, use)


def test_who_sends_to_a_page_that_is_gone_hears_of_it() -> None:
    heard: list[str] = []

    async def app(scope: Scope, receive: Receive, send: Send) -> None:
        try:
            for _ in range(1000):
                await send({"type": "websocket.send", "text": "fails"})
        except OSError as error:
            heard.append(str(error))

    async def use(application: ApplicationLoop) -> None:
        ends = Ends([])
        await application(SOCKET, ends.receive, ends.send)
        assert heard == ["gone"]

    serve(app, use)


def test_who_stops_waiting_for_a_message_loses_none() -> None:
    found: list[Message] = []

    async def app(scope: Scope, receive: Receive, send: Send) -> None:
        await send(text(0))
        for _ in range(20):
            try:
                found.append(await asyncio.wait_for(receive(), 0.01))
            except TimeoutError:
                continue
        while (message := await receive())["type"] != "websocket.disconnect":
            found.append(message)

    async def use(application: ApplicationLoop) -> None:
        ends = Ends([])
        served = asyncio.create_task(application(SOCKET, ends.receive, ends.send))
        for n in range(20):
            await asyncio.sleep(0.013)
            ends.coming.put_nowait(text(n))
        ends.coming.put_nowait({"type": "websocket.disconnect"})
        await served
        assert found == [text(n) for n in range(20)]

    serve(app, use)


def test_what_the_application_raises_and_a_cancelled_request_cross_too() -> None:
    cancelled = threading.Event()

    async def app(scope: Scope, receive: Receive, send: Send) -> None:
        if scope["path"] == "/wrong":
            raise ValueError("wrong")
        try:
            await asyncio.Event().wait()
        except asyncio.CancelledError:
            cancelled.set()
            raise

    async def use(application: ApplicationLoop) -> None:
        ends = Ends([])
        with pytest.raises(ValueError, match="wrong"):
            await application({"type": "http", "path": "/wrong"}, ends.receive, ends.send)
        served = asyncio.create_task(application(SOCKET, ends.receive, ends.send))
        await asyncio.sleep(0.05)
        served.cancel()
        with pytest.raises(asyncio.CancelledError):
            await served
        assert await asyncio.to_thread(cancelled.wait, WAIT_MAX_S)

    serve(app, use)
