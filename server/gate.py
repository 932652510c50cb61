"""The door of every request and socket: not too often, same origin, signed in; security headers on the way out."""

import math
import re
from http.cookies import CookieError

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.auth import Identity, Sessions, same_origin
from server.frames import ISOLATION
from server.rates import Rates, TooOften

BODY_MAX = 1 << 20
"""Longest request body that is read [bytes]."""
COMMAND = "/api/command"
"""Passes however often it is asked for: E-STOP must. The route itself refuses the other commands."""
COMMAND_MAX = 4096
"""Longest body there [bytes]: what is not counted must be cheap."""
_LENGTH = re.compile(r"[0-9]{1,9}")
_OPEN = re.compile(r"/|/assets/.*|/favicon\.(ico|svg)")
"""What is served to anyone: the page shell (with its sign-in form) and its assets."""
_HOST = re.compile(r"[\w.:\[\]-]+")


class Gate:
    """ASGI middleware. Whatever is not open needs a session, so a new route is closed unless it is opened here."""

    def __init__(self, app: ASGIApp, sessions: Sessions, rates: Rates) -> None:
        self._app, self._sessions, self._rates = app, sessions, rates

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let the request through with `state["who"]` set, or answer 401, 403, 411, 413 or 429."""
        if scope["type"] not in ("http", "websocket"):
            return await self._app(scope, receive, send)
        who = self._who(scope)
        late = self._late(scope, who)
        refusal = _refusal(scope, who) if late is None else too_often(late)
        scope.setdefault("state", {})["who"] = who
        app: ASGIApp = self._app if refusal is None else refusal
        await app(scope, receive, _with_headers(scope, send))

    def _late(self, scope: Scope, who: Identity | None) -> TooOften | None:
        """Why this request comes too early, if it does. Of a command the route is told so."""
        address = scope["client"][0] if scope.get("client") else ""
        late = self._rates.refusal(scope["path"], who.id if who else None, address)
        if who is None or scope["path"] != COMMAND:
            return late
        scope.setdefault("state", {})["late"] = late
        return None

    def _who(self, scope: Scope) -> Identity | None:
        try:
            return self._sessions.read(HTTPConnection(scope).cookies)
        except CookieError:
            return None


def _refusal(scope: Scope, who: Identity | None) -> JSONResponse | None:
    headers, method = Headers(scope=scope), scope.get("method", "WEBSOCKET")
    if method not in ("GET", "HEAD", "OPTIONS") and not same_origin(headers):
        return JSONResponse({"detail": "the request comes from another origin"}, 403)
    if who is None and not _is_open(scope["path"], method):
        return JSONResponse({"detail": "sign in first"}, 401)
    if "transfer-encoding" in headers:  # a body without end would be read to its end
        return JSONResponse({"detail": "say the body's length: content-length is missing"}, 411)
    length, most = headers.get("content-length", "0"), COMMAND_MAX if scope["path"] == COMMAND else BODY_MAX
    if not _LENGTH.fullmatch(length) or int(length) > most:
        return JSONResponse({"detail": f"content-length = {length[:20]}: a body has at most {most} bytes"}, 413)
    return None


def too_often(late: TooOften) -> JSONResponse:
    """The answer to a request that comes too early."""
    return JSONResponse({"detail": str(late)}, 429, {"retry-after": str(math.ceil(late.wait))})


def _is_open(path: str, method: str) -> bool:
    if method == "POST":
        return path == "/api/session"
    return method in ("GET", "HEAD") and _OPEN.fullmatch(path) is not None


def _with_headers(scope: Scope, send: Send) -> Send:
    async def send_with_headers(message: Message) -> None:
        if message["type"] in ("http.response.start", "websocket.http.response.start"):
            headers = MutableHeaders(scope=message)
            for name, value in _security(scope).items():
                headers.setdefault(name, value)
        await send(message)

    return send_with_headers


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
