"""Connections that are not without end: a head has a length, a request a time within which it is all here, and an
address a bounded number.

uvicorn alone would keep what sends a header without end, or one byte a minute.

What comes is given on in chunks, so that one connection that sends much does not hold up what others sent: a transport
hands over up to 256 kB at once, thousands of small messages. What is left over waits here, and nothing more is read,
until the connections that came meanwhile had their turn and the application took what it has.
"""

import asyncio
import re
from http import HTTPStatus
from typing import Any, cast

from uvicorn._types import ASGIReceiveEvent, ASGISendEvent
from uvicorn.protocols.http.flow_control import FlowControl
from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol
from uvicorn.protocols.utils import ClientDisconnected, get_remote_addr
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.exceptions import InvalidState
from websockets.frames import CloseCode

HEAD_MAX = 1 << 16
"""Bytes of request line and headers."""
END = re.compile(rb"\n\r?\n")
"""Of a head."""
CONNECTIONS_MAX = 1000
"""Of one address at the same time: 200 pages behind it have some 700 sockets, and what they fetch meanwhile."""
URGENT = "urgent"
"""In a socket's state: called in the network's loop with each text message as it comes in, before it is queued; True:
it was acted on."""
REQUEST_SECONDS = 30.0
"""From the connection to the end of the first head, and from there, or from a later request's first byte, to the last
byte of its body: 1 MiB at 35 kB/s."""
UNHEARD_MAX = 1 << 16
"""Bytes of messages that wait for a socket's route before no more is read: what is urgent may come behind
several seconds of a drag.
"""
CHUNK_BYTES = 1024
"""Bytes of one connection that are understood in one go."""


class Chunked(asyncio.Protocol):
    """Mixed into a protocol: `data_received` of the class behind it gets chunked."""

    transport: asyncio.Transport
    loop: asyncio.AbstractEventLoop
    _rest = b""
    _due = False

    def data_received(self, data: bytes) -> None:
        """Take what came."""
        self._rest += data
        if not self._due:
            self._feed()

    def take(self, data: bytes) -> None:
        """Understand one chunk."""
        super().data_received(data)

    def held(self) -> bool:
        """Whether the application has not taken what it was given."""
        raise NotImplementedError

    def go_on(self) -> None:
        """The application took it: go on with what waits, or read more."""
        if self._due or self.transport.is_closing():
            return
        self._due = True
        self.loop.call_soon(self._again)

    def _again(self) -> None:
        self._due = False
        if not self.transport.is_closing():
            self._feed()

    def _feed(self) -> None:
        while self._rest and not self._due and not self.held():
            data, self._rest = self._rest[:CHUNK_BYTES], self._rest[CHUNK_BYTES:]
            self.take(data)
            if self.transport.is_closing() or self.transport.get_protocol() is not self:
                return
            if self._rest:
                self.transport.pause_reading()
                self._due = not self.held()
                if self._due:
                    self.loop.call_soon(self._again)
        if not self._rest and not self.held():
            self.transport.resume_reading()


class Flow(FlowControl):
    """Backpressure of one HTTP connection: reading goes on with what waits here first."""

    def __init__(self, transport: asyncio.Transport, chunked: Chunked) -> None:
        super().__init__(transport)
        self._chunked: Chunked | None = chunked

    def resume_reading(self) -> None:
        """The request was answered, or its body taken."""
        if self.read_paused and self._chunked is not None:
            self.read_paused = False
            self._chunked.go_on()

    def end(self) -> None:
        """Nothing is read any more."""
        self._chunked = None


class ConnectionCount:
    """The connections of this process by the address they come from, oldest first; its files are counted, too."""

    most = CONNECTIONS_MAX

    def __init__(self) -> None:
        self._open: dict[str, dict[Counted, None]] = {}

    def come(self, one: "Counted") -> None:
        """Count one more."""
        self._open.setdefault(_address(one), {})[one] = None

    def go(self, one: "Counted") -> None:
        """Count one less."""
        same = self._open.get(_address(one), {})
        same.pop(one, None)
        if not same:
            self._open.pop(_address(one), None)

    def room_for(self, one: "Doorstep") -> bool:
        """Whether `one` may stay; of too many the one goes that has asked for nothing for the longest time."""
        same = self._open[_address(one)]
        if len(same) <= self.most:
            return True
        idle = next(
            (other for other in same if not isinstance(other, Socket) and other.idle and other is not one), None
        )
        if idle is not None:
            self.go(idle)  # now: it is lost a turn later, when others have come, each of whom sends one away
            idle.transport.abort()
        return idle is not None


OPEN = ConnectionCount()


def _address(one: "Counted") -> str:
    return one.client[0] if one.client else ""


class Doorstep(asyncio.Protocol):
    """A connection of which no whole head has come: it costs hardly anything, and a flood has thousands of it.

    What does not begin as a request goes through at once, and is refused there.
    """

    idle = True
    client: tuple[str, int] | None = None
    transport: asyncio.Transport

    def __init__(self, **given: Any) -> None:
        """`given` is what uvicorn has for the connection to be."""
        self._given, self._head = given, bytearray()
        self._others: set[Any] = given["server_state"].connections

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """The first request must come; 503 where one address has too many connections at work."""
        self.transport = cast(asyncio.Transport, transport)
        self.client = get_remote_addr(self.transport)
        self._others.add(self)
        OPEN.come(self)
        loop = self._given.get("_loop") or asyncio.get_running_loop()
        self._deadline = loop.call_later(Connection.seconds, self.transport.abort)
        if not OPEN.room_for(self):
            text = f"more than {OPEN.most} connections from {_address(self)}"
            refuse(self.transport, HTTPStatus.SERVICE_UNAVAILABLE, text)

    def data_received(self, data: bytes) -> None:
        """Go in with a whole head, with one that is too long, and with what is none."""
        unread = max(0, len(self._head) - 2)
        self._head += data
        if END.search(self._head, unread) or len(self._head) > HEAD_MAX or not self._head[:3].isupper():
            self._leave()
            found = Connection(**self._given)
            self.transport.set_protocol(found)
            found.connection_made(self.transport)
            found.data_received(bytes(self._head))

    def connection_lost(self, exc: Exception | None) -> None:
        """It never went in."""
        self._leave()

    def shutdown(self) -> None:
        """The server ends."""
        self.transport.close()

    def _leave(self) -> None:
        self._deadline.cancel()
        self._others.discard(self)
        OPEN.go(self)


class Connection(Chunked, HttpToolsProtocol):
    """One HTTP connection, until it becomes a WebSocket."""

    seconds = REQUEST_SECONDS
    _in_head = True
    _head = 0
    _lost = False
    flow: Flow
    _deadline: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """It came from the doorstep, with the head of its first request."""
        super().connection_made(transport)
        self.flow = Flow(transport, self)
        OPEN.come(self)
        self._begin()

    def held(self) -> bool:
        """Whether requests wait behind the one that is being answered, or its body is not taken."""
        return self.flow.read_paused or bool(self.pipeline)

    @property
    def idle(self) -> bool:
        """Whether no request is being answered."""
        return self.cycle is None or self.cycle.response_complete

    def data_received(self, data: bytes) -> None:
        """Pass on what came."""
        if self._deadline is None:
            self._begin()
        super().data_received(data)

    def take(self, data: bytes) -> None:
        """One chunk; 431 for a head that is too long."""
        self._head += len(data)
        super().take(data)
        if self._in_head and self._head > HEAD_MAX and not self.transport.is_closing():
            text = f"the request line and its headers are longer than {HEAD_MAX} bytes"
            refuse(self.transport, HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE, text)

    def on_message_begin(self) -> None:
        """Another head begins."""
        super().on_message_begin()
        self._in_head, self._head = True, 0

    def on_headers_complete(self) -> None:
        """The head is whole."""
        self._in_head = False
        super().on_headers_complete()

    def on_message_complete(self) -> None:
        """The request is whole; its answer may take its time."""
        super().on_message_complete()
        self._end()

    def on_response_complete(self) -> None:
        """The next of the requests that were read; after the last one, what waits unread."""
        super().on_response_complete()
        self.go_on()
        self._let_go()

    def handle_websocket_upgrade(self) -> None:
        """From here on the WebSocket's own pings watch."""
        self._end()
        OPEN.go(self)
        super().handle_websocket_upgrade()
        rest, self._rest = self._rest, b""
        if rest:
            self.transport.get_protocol().data_received(rest)  # type: ignore[attr-defined]

    def connection_lost(self, exc: Exception | None) -> None:
        """Nothing more is to be waited for."""
        self._end()
        OPEN.go(self)
        super().connection_lost(exc)
        self._lost = True
        self._let_go()

    def _let_go(self) -> None:
        """Hold itself no more, once it is lost and its last answer made: what does waits for the garbage collector, and
        after thousands of connections that stops all threads for 200 ms.
        """
        if self._lost and self.idle:
            self.flow.end()
            self.cycle = None  # type: ignore[assignment]

    def _begin(self) -> None:
        self._deadline = self.loop.call_later(self.seconds, self._give_up)

    def _end(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None

    def _give_up(self) -> None:
        self.transport.abort()


class Socket(Chunked, WebSocketsSansIOProtocol):
    """One WebSocket; a message that is no text ends it with 1007, without an error of uvicorn's in our log."""

    _unheard = 0

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """It counts as the connection that it was."""
        super().connection_made(transport)
        OPEN.come(self)

    def connection_lost(self, exc: Exception | None) -> None:
        """One less."""
        OPEN.go(self)
        super().connection_lost(exc)

    def held(self) -> bool:
        """Whether the route has not taken too many of the messages that it was given."""
        return self.read_paused

    def take(self, data: bytes) -> None:
        """Understand one chunk."""
        try:
            super().take(data)
        except InvalidState:  # it was to be closed once more
            self.transport.close()

    def shutdown(self) -> None:
        """The server ends. A page that is just leaving was sent the closing message: uvicorn sends it once more, fails,
        and ends nothing of what comes after it.
        """
        try:
            super().shutdown()
        except InvalidState:
            self.transport.close()

    async def receive(self) -> ASGIReceiveEvent:
        """The next message; what is urgent was acted on before."""
        message = await self.queue.get()
        self._unheard -= len((message.get("text") or "").encode() or message.get("bytes") or b"")  # type: ignore[attr-defined, arg-type]
        if self.read_paused and self._unheard < UNHEARD_MAX:
            self.read_paused = False
            self.go_on()
        return message

    async def send(self, message: ASGISendEvent) -> None:
        """Send; a page that was closed from here is gone, which is no error of its route's."""
        if self.close_sent and message["type"] == "websocket.send":
            raise ClientDisconnected
        await super().send(message)
        self.handshake_complete |= self.close_sent  # by a refusal too: else uvicorn logs it as an error of the route

    def send_receive_event_to_app(self) -> None:
        """Pass on a whole message."""
        if self.curr_msg_data_type == "text" and not _is_text(b"".join(self.frames)):
            self.conn.send_close(CloseCode.INVALID_DATA)
            self.handle_parser_exception()
        elif not self._urgent():
            self._pass_on()

    def _pass_on(self) -> None:
        if not self.close_sent:  # what comes after that is dropped, and read to its end
            self._unheard += sum(map(len, self.frames))
        self.read_paused = True  # or uvicorn stops reading at every message
        super().send_receive_event_to_app()
        self.read_paused = self._unheard >= UNHEARD_MAX
        if self.read_paused:
            self.transport.pause_reading()

    def _urgent(self) -> bool:
        """Whether the route's own reader took the message at once, before those that wait: see `URGENT`."""
        take = self.scope["state"].get(URGENT) if self.curr_msg_data_type == "text" else None
        if take is None or len(self.frames) != 1 or not take(bytes(self.frames[0])):
            return False
        self.frames = []
        return True


Counted = Doorstep | Connection | Socket


def refuse(transport: asyncio.Transport, status: HTTPStatus, detail: str) -> None:
    """Answer with this, and end the connection."""
    text = f'{{"detail": "{detail}"}}'
    head = f"HTTP/1.1 {status.value} {status.phrase}\r\ncontent-type: application/json\r\nconnection: close\r\n"
    transport.write(f"{head}content-length: {len(text)}\r\n\r\n{text}".encode())
    transport.close()


def _is_text(data: bytes) -> bool:
    try:
        data.decode()
    except UnicodeDecodeError:
        return False
    return True
