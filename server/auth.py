"""Who is who: the access token is exchanged once for a signed cookie with a random session id and a short name."""

import hashlib
import hmac
import secrets
import time
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from urllib.parse import urlsplit

from itsdangerous import BadSignature, URLSafeTimedSerializer

from controller.errors import TendrilError
from server.settings import Secrets

FAILURES = 5
"""Wrong tokens that one address may send within `PERIOD`."""
PERIOD = 60.0
MAX_AGE = 7 * 24 * 3600
"""Seconds for which a cookie is good."""
_COLOURS = ("amber", "azure", "coral", "ivory", "jade", "lilac", "ochre", "olive", "pearl", "ruby", "sepia", "teal")
_PLANTS = ("aloe", "briar", "clover", "fern", "hazel", "ivy", "laurel", "maple", "moss", "reed", "thyme", "willow")


class WrongToken(TendrilError):
    """The access token is not ours."""


class TooManyAttempts(TendrilError):
    """One address sent too many wrong tokens; wait."""


@dataclass(frozen=True)
class Identity:
    """One signed-in browser (or script): a random id, and a name that people can read out."""

    id: str
    name: str


class Sessions:
    """Opens sessions for the right token and reads them from cookies; keeps none, so a restart signs nobody out."""

    def __init__(self, kept: Secrets, rig: str, now: Callable[[], float] = time.monotonic) -> None:
        # A new token must end the sessions that the old one opened: it is part of the signing key.
        key = hashlib.sha256(f"{kept.key} {kept.token}".encode()).hexdigest()
        self._signer = URLSafeTimedSerializer(key, salt="session")
        self._token = kept.token.encode()
        self._failures: dict[str, list[float]] = defaultdict(list)
        self._now = now
        self.cookie = f"tendril_{rig}"

    def open(self, token: str, address: str) -> Identity:
        """A new session; raises as `require`."""
        self.require(token, address)
        name = f"{secrets.choice(_COLOURS)} {secrets.choice(_PLANTS)} {secrets.randbelow(90) + 10}"
        return Identity(secrets.token_urlsafe(12), name)

    def require(self, token: str, address: str) -> None:
        """Let any known access token pass.

        Raises `WrongToken`, or `TooManyAttempts` after `FAILURES` wrong ones from `address` in a minute.
        """
        recent = [t for t in self._failures[address] if t > self._now() - PERIOD]
        self._failures[address] = recent
        if len(recent) >= FAILURES:
            raise TooManyAttempts(f"{FAILURES} wrong tokens from {address}: wait {PERIOD:.0f} s")
        if not hmac.compare_digest(token.encode(), self._token):
            recent.append(self._now())
            raise WrongToken("wrong access token")
        self._failures.pop(address)

    def seal(self, who: Identity) -> str:
        """The cookie's value."""
        return str(self._signer.dumps([who.id, who.name]))

    def read(self, cookies: Mapping[str, str]) -> Identity | None:
        """Who sent these cookies; None without a valid one."""
        try:
            (found, name), signed = self._signer.loads(cookies.get(self.cookie, ""), return_timestamp=True)
        except (BadSignature, ValueError):
            return None
        # Signed in the future: a clock that was set back must sign out nobody, who may have to press E-STOP.
        return Identity(found, name) if abs(time.time() - signed.timestamp()) <= MAX_AGE else None


def same_origin(headers: Mapping[str, str]) -> bool:
    """Whether a request comes from our own page, or from no page at all (a script sends no Origin)."""
    origin = headers.get("origin")
    return origin is None or urlsplit(origin).netloc.lower() == headers.get("host", "").lower()
