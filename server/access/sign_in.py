"""An access token becomes a session, kept in a cookie."""

from dataclasses import dataclass, replace
from typing import Annotated

from fastapi import Depends, Request, Response

from server.access.lease import GivenLease, OperatorLease
from server.access.sessions import MAX_AGE, GivenSessions, Sessions
from server.http.who import Identity
from server.log.events import EventLog, GivenEvents


@dataclass(frozen=True)
class SignIn:
    """Signs browsers in, and says so in the log."""

    sessions: Sessions
    lease: OperatorLease
    events: EventLog

    def open(self, token: str, request: Request, response: Response) -> Identity:
        """Exchange the token for a cookie on `response`; a browser that is signed in stays who it is, but for its role.

        Raises WrongToken or TooManyAttempts.
        """
        fresh = self.sessions.open(token, request.client.host if request.client else "")
        known: Identity | None = request.state.who
        who = replace(fresh, id=known.id, name=known.name) if known else fresh
        secure, value = request.url.scheme == "https", self.sessions.seal(who)
        response.set_cookie(self.sessions.cookie, value, MAX_AGE, httponly=True, samesite="lax", secure=secure)
        if who.role == "viewer" and known and known.role == "operator":
            self.lease.release(who)
        if known is None or known.role != who.role:
            self.events.add(f"{who.name} signed in with the {who.role}'s token")
        return who


async def _sign_in(sessions: GivenSessions, lease: GivenLease, events: GivenEvents) -> SignIn:
    return SignIn(sessions, lease, events)


GivenSignIn = Annotated[SignIn, Depends(_sign_in)]
