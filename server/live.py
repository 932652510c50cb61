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
from server.history import History
from server.messages import Event
from server.plots.feed import Feed, encode_frame

log = logging.getLogger(__name__)

BEAT = 1 / 60
STATUS_PERIOD = 1.0
CROWD = 16
"""More viewers than these get every other beat each; who operates gets all."""
WAITING = 256
"""Text messages that may wait for a slow viewer; beyond that the oldest are dropped."""


@dataclass(frozen=True)
class Beat:
    """The newest of the rows before number `stop`, as a FRAME."""

    stop: int = 0
    frame: bytes = b""


@dataclass(eq=False)
class Viewer:
    """One open page. `cursor` is the number of the row after its last FRAME; `feed` knows what it plots."""

    socket: WebSocket
    who: Identity
    feed: Feed
    cursor: int = 0
    turn: int = 0
    """How many came before: in a crowd odd and even ones take turns."""
    presence: int = -1
    outbox: deque[str] = field(default_factory=lambda: deque(maxlen=WAITING))
    status_due: bool = True
    wake: asyncio.Event = field(default_factory=asyncio.Event)

    def post(self, message: BaseModel) -> None:
        """Send a message as soon as the socket takes it."""
        self.outbox.append(message.model_dump_json())
        self.wake.set()


class Hub:
    """All viewers and the beat.

    `status` makes the Status of one viewer, `key` changes whenever it should be sent, `operates` says who is first.
    """

    def __init__(
        self,
        history: History,
        status: Callable[[Identity], BaseModel],
        key: Callable[[], object],
        operates: Callable[[Identity], bool],
    ) -> None:
        self._history, self._status, self._key, self._operates = history, status, key, operates
        self.viewers: set[Viewer] = set()
        self.driver: Viewer | None = None
        """The page that gave the last fresh press: one of several tabs, maybe."""
        self._beats = self._come = 0
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
        self._come += 1
        viewer.turn = self._come
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
        if beat.stop > viewer.cursor:
            viewer.cursor = beat.stop
            await viewer.socket.send_bytes(beat.frame)
        if (plot := viewer.feed.next()) is not None:
            await viewer.socket.send_bytes(plot)
            if viewer.feed.behind:
                viewer.wake.set()

    def _beat_once(self) -> None:
        self._beats += 1
        if self.viewers:
            self._encode()
            self._announce()
            for viewer in self._due():
                viewer.wake.set()

    def _due(self) -> list[Viewer]:
        """Whose turn it is: everyone's, or in a crowd every other one's and the operator's."""
        if len(self.viewers) <= CROWD:
            return list(self.viewers)
        odd = self._beats % 2
        return [viewer for viewer in self.viewers if viewer.turn % 2 == odd or self._operates(viewer.who)]

    def _encode(self) -> None:
        newest, stop = self._history.newest, self._history.count
        if newest is not None and stop != self._beat.stop:
            self._beat = Beat(stop, encode_frame(newest))

    def _announce(self) -> None:
        key, now = self._key(), time.monotonic()
        if key == self._last_key and now - self._status_at < STATUS_PERIOD:
            return
        self._last_key, self._status_at = key, now
        for viewer in self.viewers:
            viewer.status_due = True
