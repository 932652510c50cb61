"""The door that every request and socket passes: same origin, signed in, and security headers on the way out."""

import re
from http.cookies import CookieError

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.auth import Identity, Sessions, TooManyAttempts, WrongToken, same_origin
from server.frames import ISOLATION
from server.monitoring.refused import Refused
from server.settings import is_loopback

BODY_MAX = 1 << 20
"""Longest request body that is read [bytes]."""
_OPEN = re.compile(r"/|/assets/.*|/favicon\.(ico|svg)")
"""What is served to anyone: the page shell (with its sign-in form) and its assets."""
FIGURES, BEARER = "/metrics", "Bearer "
_HOST = re.compile(r"[\w.:\[\]-]+")


class Gate:
    """ASGI middleware. Whatever is not open needs a session, so a new route is closed unless it is opened here."""

    def __init__(self, app: ASGIApp, sessions: Sessions, refused: Refused) -> None:
        self._app, self._sessions, self._refused = app, sessions, refused

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let the request through with `state["who"]` set, or answer 401, 403, 411, 413 or 429."""
        if scope["type"] not in ("http", "websocket"):
            return await self._app(scope, receive, send)
        who = self._who(scope)
        refusal = self._refusal(scope, who)
        scope.setdefault("state", {})["who"] = who
        app: ASGIApp = self._app if refusal is None else refusal
        await app(scope, receive, self._with_headers(scope, send))

    def _who(self, scope: Scope) -> Identity | None:
        try:
            cookies = HTTPConnection(scope).cookies
        except CookieError:
            return None
        who = self._sessions.read(cookies)
        self._refused.signatures += who is None and self._sessions.cookie in cookies
        return who

    def _refusal(self, scope: Scope, who: Identity | None) -> JSONResponse | None:
        headers, method = Headers(scope=scope), scope.get("method", "WEBSOCKET")
        if method not in ("GET", "HEAD", "OPTIONS") and not same_origin(headers):
            return JSONResponse({"detail": "the request comes from another origin"}, 403)
        if who is None and not _is_open(scope, method) and (refusal := self._unless_bearer(scope, headers)):
            return refusal
        if "transfer-encoding" in headers:  # a body without end would be read to its end
            return JSONResponse({"detail": "say the body's length: content-length is missing"}, 411)
        length = headers.get("content-length", "0")
        if not length.isdigit() or int(length) > BODY_MAX:
            return JSONResponse({"detail": f"the body is longer than {BODY_MAX} bytes"}, 413)
        return None

    def _unless_bearer(self, scope: Scope, headers: Headers) -> JSONResponse | None:
        """A program that cannot sign in may read figures with an access token; nothing else is had by one."""
        given = headers.get("authorization", "")
        if scope["path"] != FIGURES or not given.startswith(BEARER):
            return JSONResponse({"detail": "sign in first"}, 401)
        try:
            self._sessions.require(given.removeprefix(BEARER), _address(scope))
        except (WrongToken, TooManyAttempts) as error:
            return JSONResponse({"detail": str(error)}, 401 if isinstance(error, WrongToken) else 429)
        return None

    def _with_headers(self, scope: Scope, send: Send) -> Send:
        async def send_with_headers(message: Message) -> None:
            if message["type"] in ("http.response.start", "websocket.http.response.start"):
                self._refused.answer(message["status"])
                headers = MutableHeaders(scope=message)
                for name, value in _security(scope).items():
                    headers.setdefault(name, value)
            await send(message)

        return send_with_headers


def _is_open(scope: Scope, method: str) -> bool:
    path = scope["path"]
    if method == "POST":
        return bool(path == "/api/session")
    if path == "/healthz":
        return is_loopback(_address(scope))
    return method in ("GET", "HEAD") and _OPEN.fullmatch(path) is not None


def _address(scope: Scope) -> str:
    client = scope.get("client")
    return str(client[0]) if client else ""


def _security(scope: Scope) -> dict[str, str]:
    """Headers for every response. Viser's and rerun's own pages hold inline scripts, compile wasm and use blobs."""
    host = Headers(scope=scope).get("host", "")
    sockets = f" ws://{host} wss://{host}" if _HOST.fullmatch(host) else ""
    foreign = scope["path"].startswith(("/viser", "/rerun"))
    scripts = " 'unsafe-inline' 'wasm-unsafe-eval' blob:" if foreign else ""
    policy = {
        "default-src": "'self'",
        "script-src": f"'self'{scripts}",
        "worker-src": "'self' blob:",
        "style-src": "'self' 'unsafe-inline'",
        "img-src": "'self' data: blob:",
        "connect-src": f"'self' data: blob:{sockets}",
        "font-src": "'self' data:",
        "object-src": "'none'",
        "base-uri": "'self'",
        "form-action": "'self'",
        "frame-ancestors": "'self'",
    }
    return {
        "content-security-policy": "; ".join(f"{name} {value}" for name, value in policy.items()),
        "cross-origin-opener-policy": "same-origin",
        "cross-origin-embedder-policy": "require-corp",
        "cross-origin-resource-policy": "same-origin",
        "referrer-policy": "no-referrer",
        "x-content-type-options": "nosniff",
        "cache-control": "no-store" if scope["path"].startswith("/api") else "no-cache",
        **(ISOLATION if foreign else {}),
    }
