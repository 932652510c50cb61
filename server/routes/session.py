"""Sign in, and who am I."""

from fastapi import APIRouter, Request, Response

from server.auth import MAX_AGE, Identity
from server.deps import Me, Parts
from server.messages import Login, Session
from server.services import Services

router = APIRouter(tags=["session"])


def sign_in(token: str, request: Request, response: Response, parts: Services) -> Identity:
    """Exchange the token for a cookie on `response`; a browser that is signed in stays who it is."""
    address = request.client.host if request.client else ""
    fresh = parts.sessions.open(token, address)
    known: Identity | None = request.state.who
    who = known or fresh
    secure = request.url.scheme == "https"
    response.set_cookie(
        parts.sessions.cookie, parts.sessions.seal(who), MAX_AGE, httponly=True, samesite="lax", secure=secure
    )
    if known is None:
        parts.events.add(f"{who.name} signed in")
    return who


@router.post("/api/session")
async def sign_in_by_token(body: Login, request: Request, response: Response, parts: Parts) -> Session:
    """Sign in with the access token; 401 when it is wrong, 429 after too many wrong ones."""
    who = sign_in(body.token, request, response, parts)
    return Session(name=who.name, lease=parts.lease.view(who))


@router.get("/api/session")
async def read_session(parts: Parts, who: Me) -> Session:
    """Who I am, and whether I operate."""
    return Session(name=who.name, lease=parts.lease.view(who))
