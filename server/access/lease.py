"""The operator's lease: at most one session operates; it lapses when nothing is heard of its page.

A lease belongs to a session, its id and the token that opened it, so all tabs of one browser operate. Others ask for
it, and are handed it by the holder.
"""

import threading
import time
from collections.abc import Callable
from typing import Annotated

from controller.errors import CommandRefused, NotAllowed
from server.access.messages import Lease, Session
from server.http.given import given
from server.http.who import Identity

LAPSE_S = 5.0
"""Seconds without a sign of the holder after which the lease is free again; where no one listens none pass."""
ASKING_S = 60.0
"""Seconds for which a request for the lease stands."""
ASKERS_MAX = 8
"""Requests that stand at once."""
REMEMBERED_MAX = 32
"""Sessions of which it is known why they operate no longer, the last ones."""


class OperatorLease:
    """One holder or none. Thread safe in what says who holds it: permits are looked at in the threads that send."""

    def __init__(self, now: Callable[[], float] = time.monotonic, lapse: float | None = None) -> None:
        """`now()` is the time for which signs could be heard [s]; `lapse` [s] instead of LAPSE_S."""
        self._now, self._lapse = now, LAPSE_S if lapse is None else lapse
        self._holder: Identity | None = None
        self._heard = 0.0
        self._term = 0
        self._lock = threading.RLock()
        self._asked: dict[str, tuple[Identity, float]] = {}
        self._lost: dict[str, str] = {}
        """Why a session operates no longer, by its id."""
        self._listeners: list[Callable[[Identity | None, Identity | None], None]] = []
        self.clutch = False
        """Held clutch: letting go of a target holds the rig. It stays as it is from one holder to the next."""

    def listen(self, changed: Callable[[Identity | None, Identity | None], None]) -> None:
        """Call `changed` with the holder before and the one of now at every change, in whatever thread it is made."""
        self._listeners.append(changed)

    @property
    def holder(self) -> Identity | None:
        """Who operates now; a lapsed lease is free."""
        with self._lock:
            if self._holder is not None and self._now() - self._heard > self._lapse:
                self._pass_to(None, f"nothing was heard of the page for {self._lapse:g} s")
            return self._holder

    @property
    def term(self) -> int:
        """Rises with every change of the holder, so that a permit of an earlier term is known."""
        with self._lock:
            _ = self.holder  # it may have lapsed just now
            return self._term

    @property
    def asking(self) -> list[Identity]:
        """Who wants the lease, the longest waiting first."""
        self._asked = {tag: (who, t) for tag, (who, t) in self._asked.items() if self._now() - t <= ASKING_S}
        return [who for who, _ in self._asked.values()]

    def term_of(self, who: Identity) -> int | None:
        """The term in which `who` operates now; None where they do not."""
        with self._lock:
            held = who.is_session(self._holder) and self._now() - self._heard <= self._lapse
            return self._term if held else None

    def holds(self, who: Identity) -> bool:
        """Whether `who` operates now."""
        return self.term_of(who) is not None

    def require(self, who: Identity) -> int:
        """The term in which `who` operates; raises `NotAllowed` unless they do."""
        term = self.term_of(who)
        if term is None:
            holder = self.holder
            by = f"{holder.name} operates now" if holder else "no one operates now: take the lease first"
            raise NotAllowed(f"only the operator may do this; {by}")
        return term

    def acquire(self, who: Identity) -> bool:
        """Take the lease if it is free (or mine already); False when another holds it."""
        with self._lock:
            if self.holder is not None and not self.holds(who):
                return False
            self.give(who, "")
            return True

    def give(self, who: Identity, why: str) -> None:
        """Make `who` the holder, whatever session was it before; `why` that one lost it."""
        with self._lock:
            self._pass_to(who, why)
            self._heard = self._now()
        self._asked.pop(who.tag, None)

    def release(self, who: Identity, why: str = "control was released") -> bool:
        """Give the lease back, for a reason; False when `who` did not hold it."""
        with self._lock:
            if not self.holds(who):
                return False
            self._pass_to(None, why)
            return True

    def ask(self, who: Identity) -> None:
        """Ask the holder for the lease; CommandRefused where there is no one to ask, or too many do."""
        if self.holder is None or self.holds(who):
            raise CommandRefused("you operate already" if self.holder else "no one operates now, so no one can answer")
        waiting = len([other for other in self.asking if not other.is_session(who)])
        if waiting >= ASKERS_MAX:
            raise CommandRefused(f"{waiting} others have asked already, the most is {ASKERS_MAX}")
        self._asked[who.tag] = (who, self._now())

    def drop_request(self, tag: str) -> Identity | None:
        """Withdraw or refuse the request of the session `tag`; it, or None without one."""
        return self._asked.pop(tag, (None,))[0]

    def touch(self, who: Identity) -> int | None:
        """A sign of `who`'s page, which keeps the lease alive if it is theirs; the term in which they operate."""
        with self._lock:
            now = self._now()
            if not who.is_session(self._holder) or now - self._heard > self._lapse:
                return None
            self._heard = now
            return self._term

    def lost(self, who: Identity) -> str:
        """Why `who` operates no longer, "" where they do, or never did here."""
        return self._lost.get(who.id, "")

    def _pass_to(self, who: Identity | None, why: str) -> None:
        before, self._holder = self._holder, who
        if before is not who and not (who and who.is_session(before)):
            self._term += 1
            self._remember(before, who, why)
            for changed in self._listeners:
                changed(before, who)

    def _remember(self, before: Identity | None, who: Identity | None, why: str) -> None:
        if who is not None:
            self._lost.pop(who.id, None)
        if before is not None:
            self._lost.pop(before.id, None)
            self._lost[before.id] = why
        if len(self._lost) > REMEMBERED_MAX:
            del self._lost[next(iter(self._lost))]

    def view(self, who: Identity) -> Lease:
        """The lease as `who` sees it."""
        holder = self.holder
        name = holder.name if holder else ""
        mine = self.holds(who)
        return Lease(held=holder is not None, mine=mine, holder=name, clutch=self.clutch, lost=self.lost(who))

    def session(self, who: Identity, unprotected: bool) -> Session:
        """What a page should know about its own session; `unprotected`: whether others can read what it says."""
        return Session(name=who.name, role=who.role, unprotected=unprotected, lease=self.view(who))


GivenLease = Annotated[OperatorLease, given(OperatorLease)]
