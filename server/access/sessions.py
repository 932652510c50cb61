"""Who is who: the access token is exchanged once for a signed cookie with a random session id and a short name."""

import asyncio
import hashlib
import hmac
import secrets
import time
from collections import defaultdict
from collections.abc import Callable, Mapping
from typing import Annotated
from urllib.parse import urlsplit

from itsdangerous import BadSignature, URLSafeTimedSerializer

from server.access.tokens import Secrets
from server.http.errors import ServerError, TryLater
from server.http.given import given
from server.http.who import ROLES, Identity, Role

FAILURES = 5
"""Wrong tokens that one address may send within `FAILURES_WINDOW_S`."""
FAILURES_WINDOW_S = 60.0
COOKIE = "tendril_"
"""The rig's name follows: servers of several rigs on one host keep their sessions apart."""
MAX_AGE = 7 * 24 * 3600
"""Seconds for which a cookie is good."""
_COLOURS = ("amber", "azure", "coral", "ivory", "jade", "lilac", "ochre", "olive", "pearl", "ruby", "sepia", "teal")
_PLANTS = ("aloe", "briar", "clover", "fern", "hazel", "ivy", "laurel", "maple", "moss", "reed", "thyme", "willow")


class WrongToken(ServerError):
    """The access token is not ours."""

    status = 401


class TooManyAttempts(TryLater):
    """One address sent too many wrong tokens."""

    wait = FAILURES_WINDOW_S


class Sessions:
    """Opens sessions for the right token and reads them from cookies; keeps none, so a restart signs no one out."""

    def __init__(self, kept: Secrets, rig: str, now: Callable[[], float] = time.monotonic) -> None:
        self._failures: dict[str, list[float]] = defaultdict(list)
        self._now = now
        self.closed = False
        """The access tokens may have been revoked, and no one can say: no session operates, every one may look on."""
        self.cookie = COOKIE + rig
        self.use(kept)

    def use(self, kept: Secrets) -> None:
        """Put these tokens in force. The sessions that a token opened end with it: it is part of their signing key."""
        self._tokens = {role: kept.of(role).encode() for role in ROLES}
        keys = {role: hashlib.sha256(f"{kept.key} {kept.of(role)}".encode()).hexdigest() for role in ROLES}
        self._signers = {role: URLSafeTimedSerializer(keys[role], salt=f"session {role}") for role in ROLES}
        self._marks = {role: hashlib.sha256(keys[role].encode()).hexdigest()[:16] for role in ROLES}

    def open(self, token: str, address: str) -> Identity:
        """A new session; raises as `require`."""
        role = self.require(token, address)
        role = "viewer" if self.closed else role
        name = f"{secrets.choice(_COLOURS)} {secrets.choice(_PLANTS)} {secrets.randbelow(90) + 10}"
        return Identity(secrets.token_urlsafe(12), name, role, self._marks[role])

    def require(self, token: str, address: str) -> Role:
        """Whose access token this is.

        Raises `WrongToken`, or `TooManyAttempts` after `FAILURES` wrong ones from `address` in a minute.
        """
        recent = [t for t in self._failures[address] if t > self._now() - FAILURES_WINDOW_S]
        self._failures[address] = recent
        if len(recent) >= FAILURES:
            raise TooManyAttempts(f"{FAILURES} wrong tokens from {address}: wait {FAILURES_WINDOW_S:.0f} s")
        role = self._role(token.encode())
        if role is None:
            recent.append(self._now())
            raise WrongToken("wrong access token")
        self._failures.pop(address)
        return role

    def seal(self, who: Identity) -> str:
        """The cookie's value."""
        return str(self._signers[who.role].dumps([who.id, who.name]))

    def read(self, cookies: Mapping[str, str]) -> Identity | None:
        """Who sent these cookies; None without a valid one."""
        value = cookies.get(self.cookie, "")
        for role in ROLES:
            try:
                (found, name), signed = self._signers[role].loads(value, return_timestamp=True)
            except (BadSignature, ValueError):
                continue
            # Signed in the future: a clock that was set back must sign out no one, who may have to press E-STOP.
            if abs(time.time() - signed.timestamp()) <= MAX_AGE:
                shown: Role = "viewer" if self.closed else role
                return Identity(found, name, shown, self._marks[shown])
        return None

    def stands(self, who: Identity) -> bool:
        """Whether the token that opened `who`'s session is still in force."""
        return self._marks[who.role] == who.opened_by and not (self.closed and who.role == "operator")

    async def ended(self, who: Identity) -> None:
        """Returns once `who`'s session stands no more: for sockets, which show their cookie only once."""
        while self.stands(who):
            await asyncio.sleep(1.0)

    def _role(self, token: bytes) -> Role | None:
        """Whose token this is; every comparison takes the same time."""
        fits = [role for role in ROLES if hmac.compare_digest(token, self._tokens[role])]
        return fits[0] if fits else None


def same_origin(headers: Mapping[str, str]) -> bool:
    """Whether a request comes from our own page, or from no page at all (a script sends no Origin)."""
    origin = headers.get("origin")
    if origin is None:
        return True
    try:
        return urlsplit(origin).netloc.lower() == headers.get("host", "").lower()
    except ValueError:  # no address, as "http://["
        return False


GivenSessions = Annotated[Sessions, given(Sessions)]
