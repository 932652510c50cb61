"""Who may have the rig do something, looked at where the request leaves for the rig: the one check of every door.

A route or socket makes a permit when it is asked, and gives it along. Between that moment and the act lie planning,
locks, queues and waits, in which control may pass to another: so the permit decides nothing when it is made, and
`require` is called last, in the thread that sends (server/operate/operator.py,
server/rig/client.py, server/hardware/actuator.py).
"""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Annotated

from fastapi import Depends

from controller.errors import NotAllowed, TendrilError
from controller.schema.modes import STILLING, Request
from server.access.lease import GivenLease, OperatorLease
from server.access.sessions import Sessions
from server.http.given import given
from server.http.who import Identity, Me

_MOVING = (Request.FOLLOW, Request.TRACK)


@dataclass(frozen=True)
class Permit:
    """May `who` (None: this server itself) do it now? `objection` answers that again each time, in any thread."""

    who: Identity | None
    objection: Callable[[Request | None], str]
    only: frozenset[Request] | None = None
    """The only requests that it covers; None: everything that its holder may do."""
    sign: Callable[[], bool] = lambda: False
    """The page of its holder gave a fresh sign of presence; whether that counts, as the operator's."""
    signed: bool = False
    """It was made by such a sign."""
    commissioning: bool = False
    """A step of the commissioning asks by it: it may arm what is not commissioned."""

    @property
    def name(self) -> str:
        """Whose it is, for the log."""
        return self.who.name if self.who else "the server"

    def require(self, request: Request | None = None) -> None:
        """Raise NotAllowed with the reason unless it may be done now; None: something else than a request."""
        if self.only is not None and request not in self.only:
            raise NotAllowed(f"this may ask for {' or '.join(sorted(one.name for one in self.only))} alone")
        if why := self.objection(request):
            raise NotAllowed(why)

    def stands(self) -> bool:
        """Whether its holder still has what it was given for."""
        return not self.objection(None)

    def derived(self, objection: Callable[[Request | None], str]) -> "Permit":
        """Another one for the same holder, with an objection of its own, which asks this one's, too."""
        return replace(self, objection=objection, signed=False)


def own() -> Permit:
    """For what the server does by itself: it may end motion, and nothing else."""
    return Permit(None, lambda request: "", STILLING)


class Permits:
    """Makes permits for sessions, and knows when the operator's page last gave a sign. Thread safe."""

    def __init__(
        self,
        lease: OperatorLease,
        sessions: Sessions,
        timeout: Callable[[], float],
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        """`timeout()` is the rig's own `operator_timeout` [s]."""
        self._lease, self._sessions, self._timeout, self._now = lease, sessions, timeout, now
        self._sign: tuple[int, float] = (-1, 0.0)
        """Term of the lease in which the operator's page last gave a sign, and when."""

    @property
    def timeout(self) -> float:
        """For how long the rig does without a sign of who operates [s]."""
        return self._timeout()

    def operator(self, who: Identity) -> Permit:
        """For who operates now, in this term: who lost control and has it again must ask again. NotAllowed if not."""
        term = self._lease.require(who)
        return Permit(who, partial(self._objection, who, term), sign=partial(self._sign_in, who, term))

    def signed(self, who: Identity) -> Permit:
        """The same by a sign of the operator at their page, which keeps the lease and is presence."""
        term = self._lease.touch(who)
        if term is None:
            term = self._lease.require(who)
        self._sign = term, self._now()
        return Permit(who, partial(self._objection, who, term), signed=True)

    def taking(self, who: Identity, holder: Identity) -> Permit:
        """To end `holder`'s motion before `who` takes control from it, as `who` confirmed it; no longer once it has
        passed to anybody.
        """
        term = self._lease.require(holder)
        return Permit(who, partial(self._passed, who, holder, term), STILLING)

    def sign_age(self) -> float:
        """Since the page of who operates gave its last sign [s]; inf where it gave none since control was taken."""
        term, at = self._sign
        return self._now() - at if term == self._lease.term else math.inf

    def _objection(self, who: Identity, term: int, request: Request | None) -> str:
        """Why `who`, who operated in `term`, may not ask for this now, "" where they may."""
        if not self._sessions.stands(who):
            return "this session has ended: sign in again"
        if self._lease.term_of(who) != term:
            return self._lost(who)
        return self._absent(term) if request in _MOVING else ""

    def _sign_in(self, who: Identity, term: int) -> bool:
        if self._objection(who, term, None):
            return False
        self._sign = term, self._now()
        return True

    def _lost(self, who: Identity) -> str:
        try:
            self._lease.require(who)
        except TendrilError as error:
            return str(error)
        return "control was lost since this was asked for, and taken again: ask again"

    def _passed(self, who: Identity, holder: Identity, term: int, request: Request | None) -> str:
        if not self._sessions.stands(who):
            return "this session has ended: sign in again"
        return self._objection(holder, term, None) and "who operates has changed meanwhile: look again"

    def _absent(self, term: int) -> str:
        """Why nothing may begin to move though the lease is held: the operator is not at their page."""
        signed, at = self._sign
        age, most = self._now() - at, self._timeout()
        if signed == term and age <= most:
            return ""
        since = f"for {age:.1f} s, the most is {most:g} s" if signed == term else "since control was taken"
        return f"no operator is present: the operator's page gave no sign {since}"


GivenPermits = Annotated[Permits, given(Permits)]


async def holder(who: Me, lease: GivenLease) -> Identity:
    """Dependency of routes that only who operates may use; raises `NotAllowed` for others."""
    lease.require(who)
    lease.touch(who)
    return who


Holder = Annotated[Identity, Depends(holder)]
"""The session that asks, which must hold the operator's lease."""


async def _permitted(who: Holder, permits: GivenPermits) -> Permit:
    return permits.operator(who)


Permitted = Annotated[Permit, Depends(_permitted)]
"""The leave of the session that asks, which must hold the lease now, and again where its request leaves for the rig."""
