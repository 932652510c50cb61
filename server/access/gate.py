"""The door of every request and socket: our host, not too often, same origin, signed in; what was asked is audited."""

import re
from collections.abc import Mapping
from http.cookies import CookieError
from ipaddress import IPv6Address
from urllib.parse import parse_qsl

from starlette.datastructures import Headers
from starlette.requests import HTTPConnection
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.access.light import RouteRates
from server.access.roles import READING
from server.access.sessions import Sessions, TooManyAttempts, WrongToken, same_origin
from server.http.answers import RefusedCounts, refusal
from server.http.headers import STARTS, with_headers
from server.http.problems import answer
from server.http.who import Identity
from server.log.audit import Asker, Audit, Audited
from server.settings import ServerSettings, exposed, is_loopback

BODY_MAX = 1 << 20
"""Longest request body that is read [bytes]."""
COMMAND, SESSION = "/api/command", "/api/session"
"""The first passes however often it is asked for: E-STOP must, and the route itself refuses the other commands. By the
second a right access token must come in: it is looked at before anything is counted.
"""
UNCOUNTED_MAX = 4096
"""Longest body there [bytes]: what is not counted must be cheap."""
_LENGTH = re.compile(r"[0-9]{1,9}")
_OPEN = re.compile(r"/|/assets/.*|/favicon\.(ico|svg)")
"""What is served to anyone: the page shell (with its sign-in form) and its assets."""
ONCE = (b"host", b"origin", b"cookie", b"authorization", b"content-length", b"transfer-encoding", b"content-type")
"""Headers of which two would mean that someone else judges by the other one."""
FIGURES, BEARER = "/metrics", "Bearer "
LOOPBACK = ("localhost", "127.0.0.1", "[::1]")


class Hosts:
    """Judges the Host header of requests: the names by which browsers may ask for this server.

    A foreign page whose own name is made to resolve to this machine (DNS rebinding) would count as our origin: on
    loopback only loopback's names are answered. Elsewhere the names cannot be known, so all are, unless some are given.
    """

    def __init__(self, settings: ServerSettings) -> None:
        self._given = {name.lower() for name in settings.allow_host.split(",") if name}
        self._any = exposed(settings.host) and not self._given
        self._names = {*LOOPBACK, _in_address(settings.host).lower(), *self._given}
        self._standard = 443 if settings.tls_cert else 80

    def allows(self, headers: Mapping[str, str], port: int) -> bool:
        """Whether a request with these headers is meant for us; names that were given may come without the port."""
        bare = self._names if port == self._standard else self._given
        return self._any or headers.get("host", "").lower() in bare | {f"{name}:{port}" for name in self._names}


def _in_address(host: str) -> str:
    """`host` as it stands in an address."""
    try:
        return f"[{IPv6Address(host).compressed}]"
    except ValueError:
        return host


class Gate:
    """ASGI middleware. Whatever is not open needs a session, so a new route is closed unless it is opened here."""

    def __init__(
        self, app: ASGIApp, sessions: Sessions, hosts: Hosts, rates: RouteRates, audit: Audit, refused: RefusedCounts
    ) -> None:
        self._app, self._sessions, self._hosts = app, sessions, hosts
        self._rates, self._audit, self._refused = rates, audit, refused

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let the request through with `state["who"]` set, or answer 400, 401, 403, 411, 413, 421 or 429."""
        if scope["type"] not in ("http", "websocket"):
            return await self._app(scope, receive, send)
        who = self._who(scope)
        scope.setdefault("state", {})["who"] = who
        app: ASGIApp = self._refusal(scope, who) or self._app
        sending = with_headers(scope, self._counted(send))
        if not _acts(scope):
            return await app(scope, receive, sending)
        asker = Asker(who, _address(scope), f"{_method(scope)} {scope['path']}")
        await Audited(app, self._audit, asker)(scope, receive, sending)

    def _who(self, scope: Scope) -> Identity | None:
        try:
            cookies = HTTPConnection(scope).cookies
        except CookieError:
            return None
        who = self._sessions.read(cookies)
        self._refused.signatures += who is None and self._sessions.cookie in cookies
        return who

    def _refusal(self, scope: Scope, who: Identity | None) -> JSONResponse | None:
        if twice := _twice(scope):
            return refusal(400, f"{twice} is given more than once: it cannot be known which one counts")
        headers, method = Headers(scope=scope), _method(scope)
        ours, allowed = method in READING or same_origin(headers), self._hosts.allows(headers, _port(scope))
        client = who.client if who and ours else None  # a foreign page spends nothing of the session's
        if who is None and allowed and (token := _bearer(scope, headers)) is not None:
            try:
                client = f"{self._sessions.require(token, _address(scope))} {_address(scope)}"
            except (WrongToken, TooManyAttempts) as error:
                return answer(error)
        if late := self._late(scope, client):
            return late
        if not allowed:
            return refusal(421, "this server has another name; --allow-host lets it answer to more")
        if not ours:
            return refusal(403, "the request comes from another origin")
        if client is None and not is_open(scope["path"], method, _address(scope)):
            return refusal(401, "sign in first")
        return _too_long(headers, UNCOUNTED_MAX if scope["path"] in (COMMAND, SESSION) else BODY_MAX)

    def _late(self, scope: Scope, client: str | None) -> JSONResponse | None:
        """The answer to a request that comes too early. Of a command the route is told so."""
        if _signs_in(scope):
            return None
        late = self._rates.refusal(scope, client, _address(scope))
        if client is not None and scope["path"] == COMMAND:
            scope["state"]["late"], late = late, None
        return answer(late) if late else None

    def _counted(self, send: Send) -> Send:
        async def counted(message: Message) -> None:
            if message["type"] in STARTS:
                self._refused.answer(message["status"])
            await send(message)

        return counted


def _too_long(headers: Headers, most: int) -> JSONResponse | None:
    if "transfer-encoding" in headers:  # a body without end would be read to its end
        return refusal(411, "say the body's length: content-length is missing")
    length = headers.get("content-length", "0")
    if not _LENGTH.fullmatch(length) or int(length) > most:
        return refusal(413, f"content-length = {length[:20]}: a body has at most {most} bytes")
    return None


def _twice(scope: Scope) -> str:
    """The first header that decides who asks, or for what, and comes more than once; "" if none does."""
    names = [name.lower() for name, _ in scope["headers"]]
    return next((name.decode() for name in ONCE if names.count(name) > 1), "")


def _method(scope: Scope) -> str:
    return str(scope.get("method", "WEBSOCKET"))


def _signs_in(scope: Scope) -> bool:
    """Whether an access token is exchanged for a session, by the form or by the address."""
    if scope["path"] == "/":
        given = parse_qsl(scope["query_string"].decode("latin-1"), keep_blank_values=True)
        return "token" in dict(given)
    return bool(scope["path"] == SESSION) and _method(scope) == "POST"


def _bearer(scope: Scope, headers: Headers) -> str | None:
    """The access token of a program that cannot sign in: figures are read by one, and nothing else is."""
    given = headers.get("authorization", "")
    return given.removeprefix(BEARER) if scope["path"] == FIGURES and given.startswith(BEARER) else None


def _port(scope: Scope) -> int:
    return int((scope.get("server") or ("", 0))[1] or 0)


def _acts(scope: Scope) -> bool:
    """Whether this is more than reading: it changes something, opens a socket, or signs in."""
    return _method(scope) not in READING or _signs_in(scope)


def is_open(path: str, method: str, address: str) -> bool:
    """Whether a request from `address` is answered without a session."""
    if method == "POST":
        return path == SESSION
    if path == "/healthz":
        return is_loopback(address)
    return method in ("GET", "HEAD") and _OPEN.fullmatch(path) is not None


def _address(scope: Scope) -> str:
    client = scope.get("client")
    return str(client[0]) if client else ""
