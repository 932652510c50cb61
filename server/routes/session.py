"""Sign in, and who am I."""

from dataclasses import replace

from fastapi import APIRouter, Request, Response

from server.auth import MAX_AGE, Identity
from server.deps import Me, Parts
from server.messages import Login, Session
from server.services import Services

router = APIRouter(tags=["session"])


def sign_in(token: str, request: Request, response: Response, parts: Services) -> Identity:
    """Exchange the token for a cookie on `response`; a browser that is signed in stays who it is, but for its role."""
    address = request.client.host if request.client else ""
    fresh = parts.sessions.open(token, address)
    known: Identity | None = request.state.who
    who = replace(fresh, id=known.id, name=known.name) if known else fresh
    secure = request.url.scheme == "https"
    response.set_cookie(
        parts.sessions.cookie, parts.sessions.seal(who), MAX_AGE, httponly=True, samesite="lax", secure=secure
    )
    if who.role == "viewer" and known and known.role == "operator":
        parts.lease.release(who)
    if known is None or known.role != who.role:
        parts.events.add(f"{who.name} signed in with the {who.role}'s token")
    return who


@router.post("/api/session")
async def sign_in_by_token(body: Login, request: Request, response: Response, parts: Parts) -> Session:
    """Sign in with an access token; 401 when it is wrong, 429 after too many wrong ones."""
    return parts.session(sign_in(body.token, request, response, parts))


@router.get("/api/session")
async def read_session(parts: Parts, who: Me) -> Session:
    """Who I am, what I may do, and whether I operate."""
    return parts.session(who)
