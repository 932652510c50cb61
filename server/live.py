"""The live socket: one beat at 60 Hz encodes what is new once for all viewers; each viewer sends at its own pace."""

import asyncio
import secrets
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from pydantic import BaseModel
from starlette.websockets import WebSocket

from server.auth import Identity
from server.history import History
from server.looks import Looks
from server.messages import Event
from server.plots.feed import Feed, encode_frame
from server.rates import TryLater

BEAT = 1 / 60
STATUS_PERIOD = 1.0
CROWD = 16
"""More viewers than these get every other beat each; who operates gets all."""
WAITING = 256
"""Text messages that may wait for a slow viewer; beyond that the oldest are dropped."""


class Crowded(TryLater):
    """As many pages as are allowed have a live socket."""

    wait = 10.0


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
    page: str = field(default_factory=lambda: secrets.token_urlsafe(12))
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
        """Whoever gave signs for this page does so no more."""
        self._over.set()

    def post(self, message: BaseModel) -> None:
        """Send a message as soon as the socket takes it."""
        self.outbox.append(message.model_dump_json())
        self.wake.set()


class Hub:
    """All viewers and the beat. What a viewer is sent is made once for all who see the same.

    `status` makes the Status of one viewer, `key` changes whenever it should be sent, `sight` is what of it is not the
    same for all, `operates` says who is first.
    """

    seats = 200
    """Viewers at the same time."""

    def __init__(
        self,
        history: History,
        status: Callable[[Identity], BaseModel],
        key: Callable[[], object],
        sight: Callable[[Identity], str],
        operates: Callable[[Identity], bool],
    ) -> None:
        self._history, self._status, self._key = history, status, key
        self._sight, self._operates = sight, operates
        self.viewers: set[Viewer] = set()
        self.looks = Looks()
        """Everything that is done at a beat, each for itself."""
        self.driver: Viewer | None = None
        """The page that gave the last fresh press: one of several tabs, maybe."""
        self._beats = self._come = self._taken = 0
        self._statuses: dict[str, str] = {}
        """Status as JSON since the last beat, by what its viewer sees of the people."""
        self._beat = Beat()
        self._beaten = time.monotonic()
        self._last_key: object = None
        self._status_at = 0.0

    @property
    def age(self) -> float:
        """Time since the last beat [s]."""
        return time.monotonic() - self._beaten

    def page(self, name: str, who: Identity) -> Viewer | None:
        """The open page of `who`'s session that `Hello` gave this name, None without one."""
        return next((one for one in self.viewers if one.page == name and one.who.id == who.id), None)

    def tell(self, event: Event) -> None:
        """Show a line of the log to every viewer."""
        for viewer in self.viewers:
            viewer.post(event)

    @contextmanager
    def seat(self, who: Identity) -> Iterator[None]:
        """A place for one more viewer; `Crowded` when all are taken, but for who operates."""
        if self._taken >= self.seats and not self._operates(who):
            raise Crowded(f"{self._taken} pages are open, as many as viewers_max allows: close one, and try again")
        self._taken += 1
        try:
            yield
        finally:
            self._taken -= 1

    async def run(self, each_beat: Callable[[], None]) -> None:
        """Beat until cancelled; `each_beat` is called first every time, with or without viewers."""
        due = time.monotonic()
        while True:
            due = max(due + BEAT, time.monotonic())
            await asyncio.sleep(due - time.monotonic())
            self.looks.do("what is looked at at every beat", each_beat)
            self._beat_once()
            self._beaten = time.monotonic()

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
            viewer.end_presence()

    async def _send(self, viewer: Viewer) -> None:
        if viewer.status_due:
            viewer.status_due = False
            status = self.looks.do("the status", lambda: self._status_for(viewer.who))
            if status is not None:
                await viewer.socket.send_text(status)
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

    def _status_for(self, who: Identity) -> str:
        sight = self._sight(who)
        if sight not in self._statuses:
            self._statuses[sight] = self._status(who).model_dump_json()
        return self._statuses[sight]

    def _beat_once(self) -> None:
        self._beats += 1
        self._statuses.clear()
        if self.viewers:
            self.looks.do("the picture of the newest row", self._encode)
            self.looks.do("the news of the status", self._announce)
            self.looks.do("the turn of the viewers", self._wake_due)

    def _wake_due(self) -> None:
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
