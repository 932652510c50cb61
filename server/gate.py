"""The door that every request and socket passes: our host, same origin, signed in; and what was asked is audited."""

import re
from http.cookies import CookieError

from starlette.datastructures import Headers
from starlette.requests import HTTPConnection
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.audit import Asker, Audit, heard_by
from server.auth import Identity, Sessions, TooManyAttempts, WrongToken, same_origin
from server.headers import with_headers
from server.hosts import Hosts
from server.monitoring.refused import Refused
from server.roles import READING
from server.settings import is_loopback

BODY_MAX = 1 << 20
"""Longest request body that is read [bytes]."""
_OPEN = re.compile(r"/|/assets/.*|/favicon\.(ico|svg)")
"""What is served to anyone: the page shell (with its sign-in form) and its assets."""
FIGURES, BEARER = "/metrics", "Bearer "
_STARTS = ("http.response.start", "websocket.http.response.start")


class Gate:
    """ASGI middleware. Whatever is not open needs a session, so a new route is closed unless it is opened here."""

    def __init__(self, app: ASGIApp, sessions: Sessions, hosts: Hosts, audit: Audit, refused: Refused) -> None:
        self._app, self._sessions, self._hosts, self._audit, self._refused = app, sessions, hosts, audit, refused

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let the request through with `state["who"]` set, or answer 401, 403, 411, 413, 421 or 429."""
        if scope["type"] not in ("http", "websocket"):
            return await self._app(scope, receive, send)
        who = self._who(scope)
        refusal = self._refusal(scope, who)
        scope.setdefault("state", {})["who"] = who
        app: ASGIApp = self._app if refusal is None else refusal
        answer = with_headers(scope, self._counted(send))
        if not _acts(scope):
            return await app(scope, receive, answer)
        asker = Asker(who, _address(scope), f"{_method(scope)} {scope['path']}")
        await _Audited(app, self._audit, asker)(scope, receive, answer)

    def _who(self, scope: Scope) -> Identity | None:
        try:
            cookies = HTTPConnection(scope).cookies
        except CookieError:
            return None
        who = self._sessions.read(cookies)
        self._refused.signatures += who is None and self._sessions.cookie in cookies
        return who

    def _refusal(self, scope: Scope, who: Identity | None) -> JSONResponse | None:
        headers, method = Headers(scope=scope), _method(scope)
        if not self._hosts.allows(headers, (scope.get("server") or ("", 0))[1]):
            text = "this server has another name; --allow-host lets it answer to more"
            return JSONResponse({"detail": text}, 421)
        if method not in READING and not same_origin(headers):
            return JSONResponse({"detail": "the request comes from another origin"}, 403)
        if who is None and not _is_open(scope, method) and (refusal := self._unless_bearer(scope, headers)):
            return refusal
        return _too_long(headers)

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

    def _counted(self, send: Send) -> Send:
        async def counted(message: Message) -> None:
            if message["type"] in _STARTS:
                self._refused.answer(message["status"])
            await send(message)

        return counted


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


def _too_long(headers: Headers) -> JSONResponse | None:
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
