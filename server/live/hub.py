"""The live socket's downward half: what is new is encoded once for all, and sent to each at its own pace."""

import asyncio
import secrets
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from pydantic import BaseModel
from starlette.websockets import WebSocket

from controller.arrays import Rows
from controller.system.scheduler import ErrorGuard
from server.access.lease import OperatorLease
from server.http.who import Identity
from server.live.status import StatusView
from server.operate.pages import Pages
from server.plots.feed import Feed
from server.plots.messages import Kind
from server.rig.history import History

FRAME_S, FRAME_APART_S = 0.02, 0.014
"""From one frame to the next: the rig sends 60 batches a second, and may be silent."""
NEWS_S = 0.05
"""Between two looks for what of the status is new to pages, where no event tells."""
STATUS_S = 1.0
"""From one status to the next where nothing is new."""
VIEWERS_ALL_BEATS_MAX = 16
"""More viewers than these get every other frame each; who operates gets all."""
WAITING = 256
"""Text messages that may wait for a slow viewer; beyond that the oldest are dropped."""


@dataclass(frozen=True)
class NewestFrame:
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
    name: str = field(default_factory=lambda: secrets.token_urlsafe(12))
    """Names it to its own page alone."""
    outbox: deque[str] = field(default_factory=lambda: deque(maxlen=WAITING))
    status_due: bool = True
    wake: asyncio.Event = field(default_factory=asyncio.Event)
    _over: asyncio.Event = field(default_factory=asyncio.Event)

    def another_worker(self) -> asyncio.Event:
        """The page's worker has opened a presence socket; it ends at the event, as the one before does now."""
        self.end_presence()
        self._over = asyncio.Event()
        return self._over

    def end_presence(self) -> None:
        """No one gives signs for this page any more."""
        self._over.set()

    def post(self, message: BaseModel) -> None:
        """Send a message as soon as the socket takes it."""
        self.outbox.append(message.model_dump_json())
        self.wake.set()


class Hub:
    """Sends to all viewers. What is the same for several of them is made once."""

    def __init__(
        self,
        history: History,
        pages: Pages[Viewer],
        lease: OperatorLease,
        view: StatusView,
        guard: ErrorGuard,
        frame_rate: float = 60.0,
    ) -> None:
        """`frame_rate` as in the settings [Hz]; the rig's own is 60."""
        self._history, self._pages, self._lease, self._view, self._guard = history, pages, lease, view, guard
        self._frame_s = 1.0 / frame_rate - FRAME_APART_S
        self._frame_at = 0.0
        self._frames = self._come = 0
        self._statuses: dict[str, str] = {}
        """Status as JSON since the last frame, by what its viewer sees of the people."""
        self._newest = NewestFrame()
        self._last_key: object = None
        self._status_at = 0.0

    async def serve(self, viewer: Viewer, hello: Callable[[], str]) -> None:
        """Send to `viewer` until its socket or the task ends; every send is awaited, and what is stale is skipped.

        What is said from the turn on in which its `hello` is made reaches it, after that.
        """
        self._come += 1
        viewer.turn = self._come
        self._pages.open.add(viewer)
        try:
            await viewer.socket.send_text(hello())
            while True:
                await self._send(viewer)
                await viewer.wake.wait()
                viewer.wake.clear()
        finally:
            self._pages.open.discard(viewer)
            viewer.end_presence()

    def frame(self) -> None:
        """A job: what is new is made ready, and whose turn it is woken."""
        now = time.monotonic()
        if now < self._frame_at:
            return
        self._frame_at = now + self._frame_s
        self._frames += 1
        self._statuses.clear()
        if self._pages.open:
            self._guard.do("the newest frame", self._encode)
            self._guard.do("the turn of the viewers", self._wake_due)

    def announce(self) -> None:
        """A job: every page is due a status once something in it is new, and once a second."""
        if not self._pages.open:
            return
        key, now = self._view.key(), time.monotonic()
        if key == self._last_key and now - self._status_at < STATUS_S:
            return
        self._last_key, self._status_at = key, now
        for viewer in self._pages.open:
            viewer.status_due = True

    async def _send(self, viewer: Viewer) -> None:
        if viewer.status_due:
            viewer.status_due = False
            status = self._guard.do("the status", lambda: self._status_for(viewer.who))
            if status is not None:
                await viewer.socket.send_text(status)
        while viewer.outbox:
            await viewer.socket.send_text(viewer.outbox.popleft())
        newest = self._newest
        if newest.stop > viewer.cursor:
            viewer.cursor = newest.stop
            await viewer.socket.send_bytes(newest.frame)
        if (plot := viewer.feed.next()) is not None:
            await viewer.socket.send_bytes(plot)
            if viewer.feed.behind:
                viewer.wake.set()

    def _status_for(self, who: Identity) -> str:
        sight = self._view.sight(who)
        if sight not in self._statuses:
            self._statuses[sight] = self._view.status(who).model_dump_json()
        return self._statuses[sight]

    def _wake_due(self) -> None:
        for viewer in self._due():
            viewer.wake.set()

    def _due(self) -> list[Viewer]:
        """Whose turn it is: everyone's, or in a crowd every other one's and the operator's."""
        if len(self._pages.open) <= VIEWERS_ALL_BEATS_MAX:
            return list(self._pages.open)
        odd = self._frames % 2
        return [viewer for viewer in self._pages.open if viewer.turn % 2 == odd or self._lease.holds(viewer.who)]

    def _encode(self) -> None:
        newest, stop = self._history.newest, self._history.count
        if newest is not None and stop != self._newest.stop:
            self._newest = NewestFrame(stop, encode_frame(newest))


def encode_frame(newest: Rows) -> bytes:
    """FRAME message: the newest telemetry row."""
    return np.array([Kind.FRAME, 1], "<u4").tobytes() + newest.tobytes()
