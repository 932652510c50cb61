"""The application's event loop, and beside it, in a thread and loop of its own, what reads and writes the network.

Whatever pages make the application do, and however long it takes or hangs, the network goes on. Requests that
must not wait for that (an E-STOP) are answered in it; all others cross over, each with what it receives and sends.
Signs of presence cross, too: while the application hangs, an operator sees nothing, so the rig holds.
"""

import asyncio
from collections.abc import Awaitable, Callable, Coroutine
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, TypeVar

from starlette.types import ASGIApp, Message, Receive, Scope, Send

IN_FLIGHT_MAX = 4
"""Messages of one request or socket that the network has not taken yet: hello, status, frame and plot cross at once."""

T = TypeVar("T")


class ApplicationLoop:
    """An ASGI application that is called from another event loop than its own, while it runs."""

    def __init__(
        self, app: ASGIApp, here: frozenset[str], loops: Callable[[], asyncio.AbstractEventLoop] | None = None
    ) -> None:
        """Requests for the paths `here` are answered in the loop that calls. `loops` makes the application's own."""
        self._app, self._here, self._loops = app, here, loops
        self.ended = asyncio.Event()
        """In the network's loop: the application's life is over, and all that belongs to it."""

    def run(self, network: Callable[[], None]) -> None:
        """Serve in this thread until `network`, which calls this from a thread of its own, has ended."""
        with asyncio.Runner(loop_factory=self._loops) as runner:
            runner.run(self._beside(network))

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request, socket, or life of the application."""
        if scope.get("path") in self._here:
            return await self._app(scope, receive, send)
        crossing = Crossing(receive, send, self._loop)
        try:
            await self.do(_coroutine(self._app(scope, crossing.receive, crossing.send)))
            await crossing.sent()
        finally:
            crossing.end()
            if scope["type"] == "lifespan":
                self.ended.set()

    async def do(self, work: Coroutine[Any, Any, T]) -> T:
        """What comes of `work`, which the application's loop does; cancelled there where it is cancelled here."""
        return await asyncio.wrap_future(asyncio.run_coroutine_threadsafe(work, self._loop))

    async def _beside(self, network: Callable[[], None]) -> None:
        self._loop = asyncio.get_running_loop()
        with ThreadPoolExecutor(1, "network") as thread:
            await self._loop.run_in_executor(thread, network)


class Crossing:
    """What one request or socket receives and sends, between the network's loop and the application's."""

    def __init__(self, receive: Receive, send: Send, application: asyncio.AbstractEventLoop) -> None:
        """`receive` and `send` belong to the running loop, the network's."""
        self._receive, self._send = receive, send
        self._network, self._application = asyncio.get_running_loop(), application
        self._coming: Future[Message] | None = None
        self._to_send: asyncio.Queue[Message] = asyncio.Queue()
        self._given = self._taken = 0
        self._failed: Exception | None = None
        self._waits, self._room = False, asyncio.Event()
        self._sender = asyncio.create_task(self._send_all())

    async def receive(self) -> Message:
        """In the application: the next message. Who stops waiting for it loses none."""
        if self._coming is None:
            self._coming = asyncio.run_coroutine_threadsafe(_coroutine(self._receive()), self._network)
        message = await asyncio.shield(asyncio.wrap_future(self._coming))
        self._coming = None
        return message

    async def send(self, message: Message) -> None:
        """In the application: it goes on while few are in flight; raises what sending an earlier one raised."""
        while self._given - self._taken >= IN_FLIGHT_MAX and self._failed is None:
            self._room.clear()
            self._waits = True
            if self._given - self._taken >= IN_FLIGHT_MAX:  # else it was taken just now, and no one wakes us
                await self._room.wait()
            self._waits = False
        if self._failed is not None:
            raise self._failed
        self._given += 1
        self._network.call_soon_threadsafe(self._to_send.put_nowait, message)

    async def sent(self) -> None:
        """In the network's loop, when the application is done: all that it gave is sent, or has failed."""
        await self._to_send.join()

    def end(self) -> None:
        """In the network's loop: nothing more is received or sent."""
        self._sender.cancel()
        del self._sender  # it holds this: the two would wait for the garbage collector
        if self._coming is not None:
            self._coming.cancel()

    async def _send_all(self) -> None:
        while True:
            message = await self._to_send.get()
            try:
                await self._send(message)
            except Exception as error:
                self._failed = error
            self._taken += 1
            self._to_send.task_done()
            if self._waits:
                self._application.call_soon_threadsafe(self._room.set)


async def _coroutine(awaited: Awaitable[T]) -> T:
    return await awaited
