"""The live socket: one beat at 60 Hz encodes what is new once for all viewers; each viewer sends at its own pace."""

import asyncio
import logging
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from pydantic import BaseModel
from starlette.websockets import WebSocket

from server.auth import Identity
from server.history import BIN_TICKS, History, encode_frame, encode_plot
from server.messages import Event

log = logging.getLogger(__name__)

BEAT = 1 / 60
STATUS_PERIOD = 1.0
BACKLOG = 30_000
"""Rows of history that a new (or very slow) viewer gets: 30 s at 1 kHz."""
WAITING = 256
"""Text messages that may wait for a slow viewer; beyond that the oldest are dropped."""


@dataclass(frozen=True)
class Beat:
    """What the rows [start, stop) became: the newest as a FRAME, all of them as one PLOT bin."""

    start: int = 0
    stop: int = 0
    frame: bytes = b""
    plot: bytes = b""


@dataclass(eq=False)
class Viewer:
    """One open page. `cursor` is the number of the first row it has not been sent."""

    socket: WebSocket
    who: Identity
    cursor: int = 0
    presence: int = -1
    outbox: deque[str] = field(default_factory=lambda: deque(maxlen=WAITING))
    status_due: bool = True
    wake: asyncio.Event = field(default_factory=asyncio.Event)

    def post(self, message: BaseModel) -> None:
        """Send a message as soon as the socket takes it."""
        self.outbox.append(message.model_dump_json())
        self.wake.set()


class Hub:
    """All viewers and the beat. `status` makes the Status of one viewer, `key` changes whenever it should be sent."""

    def __init__(self, history: History, status: Callable[[Identity], BaseModel], key: Callable[[], object]) -> None:
        self._history, self._status, self._key = history, status, key
        self.viewers: set[Viewer] = set()
        self._beat = Beat()
        self._last_key: object = None
        self._status_at = 0.0

    def tell(self, event: Event) -> None:
        """Show a line of the log to every viewer."""
        for viewer in self.viewers:
            viewer.post(event)

    async def run(self, each_beat: Callable[[], None]) -> None:
        """Beat until cancelled; `each_beat` is called first every time, with or without viewers."""
        due = time.monotonic()
        while True:
            due = max(due + BEAT, time.monotonic())
            await asyncio.sleep(due - time.monotonic())
            try:
                each_beat()
                self._beat_once()
            except Exception:  # one bad row must not end the beat for everyone
                log.exception("beat failed")

    async def serve(self, viewer: Viewer) -> None:
        """Send to `viewer` until its socket or the task ends; every send is awaited, and what is stale is skipped."""
        if not self.viewers:  # nothing was encoded meanwhile: the first beat must not be one long bin
            self._beat = Beat(stop=self._history.count)
        viewer.cursor = max(0, self._history.count - BACKLOG)
        self.viewers.add(viewer)
        try:
            while True:
                await self._send(viewer)
                await viewer.wake.wait()
                viewer.wake.clear()
        finally:
            self.viewers.discard(viewer)

    async def _send(self, viewer: Viewer) -> None:
        if viewer.status_due:
            viewer.status_due = False
            await viewer.socket.send_text(self._status(viewer.who).model_dump_json())
        while viewer.outbox:
            await viewer.socket.send_text(viewer.outbox.popleft())
        beat = self._beat
        if beat.frame and beat.stop > viewer.cursor:
            plot = beat.plot if viewer.cursor == beat.start else self._catch_up(viewer.cursor, beat.stop)
            viewer.cursor = beat.stop
            await viewer.socket.send_bytes(beat.frame)
            await viewer.socket.send_bytes(plot)

    def _beat_once(self) -> None:
        if self.viewers:
            self._encode()
            self._announce()
            for viewer in self.viewers:
                viewer.wake.set()

    def _catch_up(self, start: int, stop: int) -> bytes:
        return encode_plot(self._history.bins(max(start, stop - BACKLOG), stop, BIN_TICKS))

    def _encode(self) -> None:
        newest, stop = self._history.newest, self._history.count
        start = self._beat.stop
        if newest is None or stop == start:
            return
        bins = self._history.bins(start, stop, max(1, stop - start))
        self._beat = Beat(start, stop, encode_frame(newest), encode_plot(bins))

    def _announce(self) -> None:
        key, now = self._key(), time.monotonic()
        if key == self._last_key and now - self._status_at < STATUS_PERIOD:
            return
        self._last_key, self._status_at = key, now
        for viewer in self.viewers:
            viewer.status_due = True
