"""The audit log: who did what, from where, and what came of it, refusals too; a file that its owner alone can read.

The gate writes every request that changes something, with what the event log said meanwhile; a socket writes line
by line.
"""

import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from datetime import UTC, datetime

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from controller.schema.layout import Model
from server.http.headers import STARTS
from server.http.rates import AUDITED, CLIENTS_MAX, SIGN_IN, STRANGE, Bucket
from server.http.who import Identity
from server.log.event_file import EventFile
from server.log.line_writer import LineWriter

LARGEST = 20_000_000
"""Bytes at which the file becomes the older one."""
DETAIL = 500
ACTION = 200
"""Characters of each that are kept: both may quote what a stranger sent."""

_hearer: ContextVar[Callable[[str], None] | None] = ContextVar("hearer", default=None)


class AuditEntry(Model):
    """One line of the audit log."""

    time: datetime
    name: str
    """Short name of the session, "" before it signed in."""
    role: str
    address: str
    action: str
    """Method and path, never the query: it may hold a token."""
    status: int
    """HTTP status of the answer; 101 for what was said on a socket."""
    detail: str
    """What the event log said about it."""


@dataclass(frozen=True)
class Asker:
    """Who does something, from where, by which request or socket."""

    who: Identity | None
    address: str
    action: str

    def entry(self, status: int, detail: str = "") -> AuditEntry:
        """What came of it, as a line."""
        return AuditEntry(
            time=datetime.now(UTC),
            name=self.who.name if self.who else "",
            role=self.who.role if self.who else "",
            address=self.address,
            action=self.action[:ACTION],
            status=status,
            detail=detail[:DETAIL],
        )


def tell(text: str) -> None:
    """Say what happens, to the audit of the request or socket that this is part of."""
    hearer = _hearer.get()
    if hearer is not None:
        hearer(text)


@contextmanager
def heard_by(hearer: Callable[[str], None]) -> Iterator[None]:
    """While this lasts, `hearer` gets what is told here and in the tasks begun here."""
    token = _hearer.set(hearer)
    try:
        yield
    finally:
        _hearer.reset(token)


class Audit:
    """Writes the lines, never waiting for the disk. `complain` hears what became of the file; what is done goes on."""

    def __init__(
        self, file: EventFile[AuditEntry], complain: Callable[[str], None], now: Callable[[], float] = time.monotonic
    ) -> None:
        self.writer = LineWriter(file, "audit log", "the audit log cannot be written")
        self._complain = complain
        self._known, self._strange, self._entering = (Bucket(rate, now=now) for rate in (AUDITED, STRANGE, SIGN_IN))
        self._left_out: Counter[str] = Counter()

    def note(self, asker: Asker, status: int, detail: str = "") -> None:
        """Write what came of it, unless this client fills the file; its next line says how many are not there."""
        client = asker.who.client if asker.who else asker.address
        lines = self._known if asker.who else self._strange if status >= 400 else self._entering
        if lines.wait(client):
            return self._leave_out(client)
        more = self._left_out.pop(client, 0)
        self.writer.append(asker.entry(status, f"{detail} (and {more} more since the last line)" if more else detail))

    def look(self) -> None:
        """A job: say what became of the file."""
        if news := self.writer.news():
            self._complain(news)

    def _leave_out(self, client: str) -> None:
        if len(self._left_out) >= CLIENTS_MAX:
            self._left_out.clear()
        self._left_out[client] += 1


class Audited:
    """A request or socket under the audit's eyes: runs `app`, and has the audit log say what came of it."""

    def __init__(self, app: ASGIApp, audit: Audit, asker: Asker) -> None:
        self._app, self._audit, self._asker = app, audit, asker
        self._said: list[str] = []
        self._noted = False

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Run to the end."""

        async def watched(message: Message) -> None:
            if message["type"] in STARTS:
                self._note(message["status"])
            elif message["type"] == "websocket.accept":
                self._note(101, "opened")
            elif message["type"] == "websocket.close" and not self._noted:
                self._note(403)
            await send(message)

        with heard_by(self._hear):
            await self._app(scope, receive, watched)

    def _hear(self, text: str) -> None:
        """Before the answer it explains the answer; on an open socket it is an act of its own."""
        if self._noted:
            self._audit.note(self._asker, 101, text)
        else:
            self._said.append(text)

    def _note(self, status: int, detail: str = "") -> None:
        self._noted = True
        self._audit.note(self._asker, status, detail or "; ".join(self._said))
