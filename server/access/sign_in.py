"""Sign in: an access token becomes a session, kept in a cookie; and who am I."""

from dataclasses import dataclass, replace
from typing import Annotated

from fastapi import APIRouter, Request, Response

from server.access.lease import GivenLease, OperatorLease
from server.access.messages import Login, Session
from server.access.sessions import MAX_AGE, Sessions
from server.http.given import GivenSettings, given
from server.http.who import Identity, Me
from server.log.events import EventLog


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


GivenSignIn = Annotated[SignIn, given(SignIn)]


router = APIRouter(tags=["session"])


@router.post("/api/session")
async def sign_in_by_token(
    body: Login, request: Request, response: Response, sign_in: GivenSignIn, settings: GivenSettings
) -> Session:
    """Sign in with an access token; 401 when it is wrong, 429 after too many wrong ones."""
    who = sign_in.open(body.token, request, response)
    return sign_in.lease.session(who, settings.unprotected)


@router.get("/api/session")
async def read_session(lease: GivenLease, settings: GivenSettings, who: Me) -> Session:
    """Who I am, what I may do, and whether I operate."""
    return lease.session(who, settings.unprotected)
