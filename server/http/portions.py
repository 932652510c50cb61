"""What comes on a connection, given on in portions: one that sends much does not hold up what others sent.

A transport hands over up to 256 kB at once, thousands of small messages. Whatever is left over waits here, and nothing
more is read, until the connections that came meanwhile had their turn and the application took what it has.
"""

import asyncio

from uvicorn.protocols.http.flow_control import FlowControl

PORTION = 4096
"""Bytes of one connection that are understood in one go."""


class Portions(asyncio.Protocol):
    """Mixed into a protocol: `data_received` of the class behind it gets portions."""

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
        """Understand one portion."""
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
            data, self._rest = self._rest[:PORTION], self._rest[PORTION:]
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

    def __init__(self, transport: asyncio.Transport, portions: Portions) -> None:
        super().__init__(transport)
        self._portions = portions

    def resume_reading(self) -> None:
        """The request was answered, or its body taken."""
        if self.read_paused:
            self.read_paused = False
            self._portions.go_on()
