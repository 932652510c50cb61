"""The pages that are open, each with its live socket: who is here, how many may be, and what all are told."""

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Annotated, Any, Generic, Protocol, TypeVar

from pydantic import BaseModel

from server.access.lease import OperatorLease
from server.http.errors import TryLater
from server.http.given import given
from server.http.who import Identity
from server.log.events import LogEntry

ROUND_TRIP_NEWS_S = 5.0
"""Seconds for which a page's round trip is news."""


class Crowded(TryLater):
    """As many pages as are allowed have a live socket."""

    status = 503
    wait = 10.0


class Page(Protocol):
    """An open page; `name` is known to it alone."""

    who: Identity
    name: str

    def post(self, message: BaseModel) -> None:
        """Send it a message as soon as its socket takes it."""


P = TypeVar("P", bound=Page)


class Pages(Generic[P]):
    """Only the event loop uses it. `seats` pages may be open at the same time, and the operator's."""

    def __init__(self, lease: OperatorLease, seats: int, now: Callable[[], float] = time.monotonic) -> None:
        self._lease, self.seats, self._now = lease, seats, now
        self.open: set[P] = set()
        self._taken = 0
        self._round_trip = (math.nan, -math.inf)

    def present(self) -> list[Identity]:
        """The session of every open page."""
        return [page.who for page in self.open]

    def named(self, name: str, who: Identity) -> P | None:
        """The open page of `who`'s session that `Hello` gave this name, None without one."""
        return next((page for page in self.open if page.name == name and page.who.is_session(who)), None)

    def tell(self, event: LogEntry) -> None:
        """Show a line of the log to every page."""
        for page in self.open:
            page.post(event)

    def tell_session(self, who: Identity, message: BaseModel) -> None:
        """Send a message to each open page of `who`'s session."""
        for page in self.open:
            if page.who.is_session(who):
                page.post(message)

    @contextmanager
    def seat(self, who: Identity) -> Iterator[None]:
        """A place for one more; `Crowded` when all are taken, but for who operates."""
        if self._taken >= self.seats and not self._lease.holds(who):
            raise Crowded(f"{self._taken} pages are open, as many as viewers_max allows: close one, and try again")
        self._taken += 1
        try:
            yield
        finally:
            self._taken -= 1

    def hear_round_trip(self, who: Identity, seconds: float) -> None:
        """A page measured its way to this server and back; the operator's counts."""
        if self._lease.holds(who):
            self._round_trip = (seconds, self._now())

    @property
    def round_trip(self) -> float:
        """Of the operator's page [s], nan where it is not known."""
        seconds, heard = self._round_trip
        return seconds if self._now() - heard < ROUND_TRIP_NEWS_S else math.nan


GivenPages = Annotated[Pages[Any], given(Pages)]
