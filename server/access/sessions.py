"""Who is who: the access token is exchanged once for a signed cookie with a random session id and a short name.

A session has one id and one role: another role is another session, and the one before it ends.
"""

import asyncio
import hashlib
import hmac
import secrets
import time
from collections.abc import Mapping
from typing import Annotated
from urllib.parse import urlsplit

from itsdangerous import BadSignature, URLSafeTimedSerializer

from server.access.ended import EndedSessions
from server.access.tokens import Secrets
from server.http.errors import ServerError, TryLater
from server.http.given import given
from server.http.rates import Rates
from server.http.who import ROLES, Identity, Role

COOKIE = "tendril_"
"""Rig and port follow: a browser has one jar for all ports of a host, in which each server must find its own."""
MAX_AGE = 7 * 24 * 3600
"""Seconds for which a cookie is good."""
_COLOURS = ("amber", "azure", "coral", "ivory", "jade", "lilac", "ochre", "olive", "pearl", "ruby", "sepia", "teal")
_PLANTS = ("aloe", "briar", "clover", "fern", "hazel", "ivy", "laurel", "maple", "moss", "reed", "thyme", "willow")


class WrongToken(ServerError):
    """The access token is not ours."""

    status = 401


class TooManyAttempts(TryLater):
    """One address sent too many wrong tokens, and this is another one."""

    def __init__(self, address: str, wait: float) -> None:
        super().__init__(f"too many wrong access tokens from {address}, the last one just now; wait {wait:.0f} s")
        self.wait = wait


def cookie_name(rig: str, port: int) -> str:
    """The name under which the server of `rig` at `port` keeps sessions."""
    return f"{COOKIE}{rig}_{port}"


class Sessions:
    """Opens sessions for the right token and reads them from cookies; keeps none but those that have ended, so a
    restart signs no one out.
    """

    def __init__(
        self, kept: Secrets, cookie: str, ended: EndedSessions | None = None, rates: Rates | None = None
    ) -> None:
        """`cookie` is the name of this server's, and good for this one alone."""
        self._rates = rates or Rates()
        self.closed = False
        """The access tokens may have been revoked, and no one can say: no session operates, every one may look on."""
        self.cookie, self._ended = cookie, ended or EndedSessions()
        self.use(kept)

    def use(self, kept: Secrets) -> None:
        """Put these tokens in force. The sessions that a token opened end with it: it is part of their signing key."""
        self._kept, self._tokens = kept, {role: kept.of(role).encode() for role in ROLES}
        parts = {role: f"{kept.key} {kept.of(role)} {self.cookie} {self._ended.series(role)}" for role in ROLES}
        keys = {role: hashlib.sha256(parts[role].encode()).hexdigest() for role in ROLES}
        self._signers = {role: URLSafeTimedSerializer(keys[role], salt=f"session {role}") for role in ROLES}
        self._marks = {role: hashlib.sha256(keys[role].encode()).hexdigest()[:16] for role in ROLES}

    def open(self, token: str, address: str) -> Identity:
        """A new session; raises as `require`."""
        role = self.require(token, address)
        role = "viewer" if self.closed else role
        name = f"{secrets.choice(_COLOURS)} {secrets.choice(_PLANTS)} {secrets.randbelow(90) + 10}"
        id = secrets.token_urlsafe(12)
        return Identity(id, name, role, self._marks[role], user=id, budget=self._rates.budget(role, address))

    def end(self, who: Identity) -> None:
        """End the session `who`: its cookie, wherever there is a copy, opens nothing any more."""
        self._ended.end(who)

    def end_all(self, role: Role) -> None:
        """End all sessions that the token of `role` has opened; it is good for new ones."""
        self._ended.end_all(role)
        self.use(self._kept)

    def keep_ended(self) -> None:
        """As `EndedSessions.keep`."""
        self._ended.keep()

    def require(self, token: str, address: str) -> Role:
        """Whose access token this is, which a right one is told however many wrong ones came from `address`.

        Raises `WrongToken`, or `TooManyAttempts` where that is one too many.
        """
        role = self._role(token.encode())
        if role is not None:
            return role
        if wait := self._rates.wrong_token(address):
            raise TooManyAttempts(address, wait)
        raise WrongToken("wrong access token")

    def seal(self, who: Identity) -> str:
        """The cookie's value."""
        return str(self._signers[who.role].dumps([who.id, who.name, who.user, who.budget]))

    def read(self, cookies: Mapping[str, str]) -> Identity | None:
        """Who sent these cookies; None without a valid one."""
        if not (value := cookies.get(self.cookie, "")):
            return None
        for role in ROLES:
            try:
                (found, name, user, budget), signed = self._signers[role].loads(value, return_timestamp=True)
            except (BadSignature, ValueError):
                continue
            # Signed in the future: a clock that was set back must sign out no one, who may have to press E-STOP.
            if abs(time.time() - signed.timestamp()) <= MAX_AGE and found not in self._ended.ids:
                shown: Role = "viewer" if self.closed else role
                return Identity(found, name, shown, self._marks[shown], user, budget)
        return None

    def stands(self, who: Identity) -> bool:
        """Whether `who`'s session is not over, and the token that opened it still in force."""
        in_force = self._marks[who.role] == who.opened_by and not (self.closed and who.role == "operator")
        return in_force and who.id not in self._ended.ids

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
