"""Sign in, and who am I."""

from fastapi import APIRouter, Request, Response

from server.access.lease import GivenLease
from server.access.messages import Login, Session
from server.access.sign_in import GivenSignIn
from server.http.given import GivenSettings
from server.http.who import Me

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
