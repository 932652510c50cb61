"""The audit log: who did what, from where, and what came of it, refusals too; a file that its owner alone can read.

The gate writes every request that changes something, with what the event log said meanwhile; a socket writes line
by line.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from datetime import UTC, datetime

from controller.layout import Model
from server.auth import Identity
from server.event_file import EventFile

LARGEST = 20_000_000
"""Bytes at which the file becomes the older one."""
DETAIL = 500
ACTION = 200
"""Characters of each that are kept: both may quote what a stranger sent."""
PERIOD = 60.0
"""A stranger's refusals within so many seconds are one line, or they would push everything else out of the file."""
STRANGERS = 1000
"""Addresses that are remembered for it."""

_hearer: ContextVar[Callable[[str], None] | None] = ContextVar("hearer", default=None)


class Deed(Model):
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

    def deed(self, status: int, detail: str = "") -> Deed:
        """What came of it, as a line."""
        return Deed(
            time=datetime.now(UTC),
            name=self.who.name if self.who else "",
            role=self.who.role if self.who else "",
            address=self.address,
            action=self.action[:ACTION],
            status=status,
            detail=detail[:DETAIL],
        )


def tell(text: str) -> None:
    """Say what happens, to whoever audits the request or socket that this is part of."""
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
    """Writes the lines. `complain` hears once that the file cannot be written; what is done goes on."""

    def __init__(
        self, file: EventFile[Deed], complain: Callable[[str], None], now: Callable[[], float] = time.monotonic
    ) -> None:
        self._file: EventFile[Deed] | None = file
        self._complain, self._now = complain, now
        self._strangers: dict[str, tuple[float, int]] = {}

    def note(self, asker: Asker, status: int, detail: str = "") -> None:
        """Write what came of it."""
        if asker.who is None and status >= 400:
            more = self._again(asker.address)
            if more is None:
                return
            detail = f"{detail} (and {more} more since the last line)" if more else detail
        self._write(asker.deed(status, detail))

    def _again(self, address: str) -> int | None:
        """How many refusals of this stranger were left out before this one; None: leave this one out too."""
        since, left_out = self._strangers.pop(address, (-PERIOD, 0))
        first = self._now() - since >= PERIOD
        self._strangers[address] = (self._now(), 0) if first else (since, left_out + 1)
        if len(self._strangers) > STRANGERS:
            del self._strangers[next(iter(self._strangers))]
        return left_out if first else None

    def _write(self, deed: Deed) -> None:
        if self._file is None:
            return
        try:
            self._file.append(deed)
        except OSError as error:
            self._file = None
            self._complain(f"the audit log cannot be written: {error.strerror}")
