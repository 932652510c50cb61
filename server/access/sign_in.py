"""Sign in and out: an access token becomes a session, kept in a cookie, until that ends; and who am I."""

import asyncio
from dataclasses import dataclass, replace
from typing import Annotated

from fastapi import APIRouter, Request, Response

from controller.errors import NotAllowed
from controller.system.scheduler import Scheduler
from server.access.lease import GivenLease, OperatorLease
from server.access.messages import Login, Session
from server.access.sessions import MAX_AGE, Sessions
from server.http.given import GivenSettings, given
from server.http.who import Identity, Me, Role
from server.log.events import EventLog


@dataclass(frozen=True)
class SignIn:
    """Signs browsers in and out, and says so in the log."""

    sessions: Sessions
    lease: OperatorLease
    events: EventLog
    scheduler: Scheduler

    def open(self, token: str, request: Request, response: Response) -> Identity:
        """Exchange the token for a cookie on `response`.

        A browser that is signed in stays who it is, unless its role changes: then it keeps its name, in a session of
        its own, and the one before is over, so that a cookie copied from it rises with no one. Raises WrongToken or
        TooManyAttempts.
        """
        fresh = self.sessions.open(token, request.client.host if request.client else "")
        known: Identity | None = request.state.who
        if known is not None and known.role == fresh.role and not self.sessions.closed:
            self._set_cookie(known, request, response)
            return known
        who = replace(fresh, name=known.name, user=known.user) if known else fresh
        self._set_cookie(who, request, response)
        self._tell(who, f"signed in with the {who.role}'s token")
        if known is not None:
            self._end(known, f"it signed in with the {who.role}'s token")
            # Not waited for: who signs in to press E-STOP must not wait for a disk.
            self.scheduler.begin("the end of a session", self._keep())
        return who

    async def close(self, who: Identity) -> None:
        """Sign this session out, wherever its cookie is."""
        self._end(who, "it signed out")
        self._tell(who, "signed out")
        await self._keep()

    async def close_all(self, role: Role, who: Identity) -> None:
        """Sign out every session that the token of `role` has opened; NotAllowed without the operator's token."""
        if who.role != "operator":
            raise NotAllowed("only who signed in with the operator's token may sign others out")
        self.sessions.end_all(role)
        holder = self.lease.holder
        if holder is not None and not self.sessions.stands(holder):
            self.lease.release(holder, f"{who.name} signed it out")
        self.events.add(f"{who.name} signed out all who came with the {role}'s token", "warning")
        await self._keep()

    def _tell(self, who: Identity, what: str) -> None:
        if not who.budget:  # of those that come too fast no line is written, which would push out what others did
            self.events.add(f"{who.name} {what}")

    def _end(self, who: Identity, why: str) -> None:
        self.sessions.end(who)
        self.lease.release(who, why)
        self.lease.drop_request(who.tag)

    async def _keep(self) -> None:
        try:
            await asyncio.to_thread(self.sessions.keep_ended)
        except OSError as error:
            self.events.add(f"sessions that ended may stand again after a restart of this server: {error}", "error")

    def _set_cookie(self, who: Identity, request: Request, response: Response) -> None:
        secure, value = request.url.scheme == "https", self.sessions.seal(who)
        response.set_cookie(self.sessions.cookie, value, MAX_AGE, httponly=True, samesite="lax", secure=secure)


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


@router.delete("/api/session", status_code=204)
async def sign_out(response: Response, sign_in: GivenSignIn, who: Me) -> None:
    """Sign out: this session is over, and so is every copy of its cookie; a motion of its own is held."""
    await sign_in.close(who)
    response.delete_cookie(sign_in.sessions.cookie, httponly=True, samesite="lax")


@router.delete("/api/sessions/{role}", status_code=204)
async def sign_out_all(role: Role, sign_in: GivenSignIn, who: Me) -> None:
    """Sign out every session of this role's token; the token stays good. 403 without the operator's token."""
    await sign_in.close_all(role, who)
