"""The door that every request and socket passes: our host, same origin, signed in; and what was asked is audited."""

import re
from http.cookies import CookieError

from starlette.datastructures import Headers
from starlette.requests import HTTPConnection
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.audit import Asker, Audit, heard_by
from server.auth import Identity, Sessions, same_origin
from server.headers import with_headers
from server.hosts import Hosts
from server.roles import READING

BODY_MAX = 1 << 20
"""Longest request body that is read [bytes]."""
_OPEN = re.compile(r"/|/assets/.*|/favicon\.(ico|svg)")
"""What is served to anyone: the page shell (with its sign-in form) and its assets."""
_STARTS = ("http.response.start", "websocket.http.response.start")


class Gate:
    """ASGI middleware. Whatever is not open needs a session, so a new route is closed unless it is opened here."""

    def __init__(self, app: ASGIApp, sessions: Sessions, hosts: Hosts, audit: Audit) -> None:
        self._app, self._sessions, self._hosts, self._audit = app, sessions, hosts, audit

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let the request through with `state["who"]` set, or answer 401, 403, 411, 413 or 421."""
        if scope["type"] not in ("http", "websocket"):
            return await self._app(scope, receive, send)
        who = self._who(scope)
        refusal = self._refusal(scope, who)
        scope.setdefault("state", {})["who"] = who
        app: ASGIApp = self._app if refusal is None else refusal
        answer = with_headers(scope, send)
        if not _acts(scope):
            return await app(scope, receive, answer)
        asker = Asker(who, (scope.get("client") or ("",))[0], f"{_method(scope)} {scope['path']}")
        await _Audited(app, self._audit, asker)(scope, receive, answer)

    def _who(self, scope: Scope) -> Identity | None:
        try:
            return self._sessions.read(HTTPConnection(scope).cookies)
        except CookieError:
            return None

    def _refusal(self, scope: Scope, who: Identity | None) -> JSONResponse | None:
        headers = Headers(scope=scope)
        if not self._hosts.allows(headers, (scope.get("server") or ("", 0))[1]):
            text = "this server has another name; --allow-host lets it answer to more"
            return JSONResponse({"detail": text}, 421)
        return _refusal(headers, _method(scope), scope["path"], who)


class _Audited:
    """Runs `app`, and has the audit log say what came of it."""

    def __init__(self, app: ASGIApp, audit: Audit, asker: Asker) -> None:
        self._app, self._audit, self._asker = app, audit, asker
        self._said: list[str] = []
        self._noted = False

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def watched(message: Message) -> None:
            if message["type"] in _STARTS:
                self._note(message["status"])
            elif message["type"] == "websocket.accept":
                self._note(101, "opened")
            elif message["type"] == "websocket.close" and not self._noted:
                self._note(403)
            await send(message)

        with heard_by(self._hear):
            await self._app(scope, receive, watched)

    def _hear(self, text: str) -> None:
        """Before the answer it explains the answer; on an open socket it is an act of its own."""
        if self._noted:
            self._audit.note(self._asker, 101, text)
        else:
            self._said.append(text)

    def _note(self, status: int, detail: str = "") -> None:
        self._noted = True
        self._audit.note(self._asker, status, detail or "; ".join(self._said))


def _refusal(headers: Headers, method: str, path: str, who: Identity | None) -> JSONResponse | None:
    if method not in READING and not same_origin(headers):
        return JSONResponse({"detail": "the request comes from another origin"}, 403)
    if who is None and not _is_open(path, method):
        return JSONResponse({"detail": "sign in first"}, 401)
    if "transfer-encoding" in headers:  # a body without end would be read to its end
        return JSONResponse({"detail": "say the body's length: content-length is missing"}, 411)
    length = headers.get("content-length", "0")
    if not length.isdigit() or int(length) > BODY_MAX:
        return JSONResponse({"detail": f"the body is longer than {BODY_MAX} bytes"}, 413)
    return None


def _method(scope: Scope) -> str:
    return str(scope.get("method", "WEBSOCKET"))


def _acts(scope: Scope) -> bool:
    """Whether this is more than reading: it changes something, opens a socket, or signs in by the address."""
    signs_in = scope["path"] == "/" and b"token=" in scope["query_string"]
    return _method(scope) not in READING or signs_in


def _is_open(path: str, method: str) -> bool:
    if method == "POST":
        return path == "/api/session"
    return method in ("GET", "HEAD") and _OPEN.fullmatch(path) is not None
