"""How often one client may ask: generous to a page at work, strict to strangers and with what keeps a core busy.

A client is a signed-in session, without one an address. Each has a bucket of tokens of every kind: a request takes one,
and they come back at a rate. What is refused takes none, so a client that waits as long as it is told gets through.

Two things are never refused: an E-STOP, and a right access token, however many wrong ones come from the same address,
as many people may be behind one. Who comes with the right one again and again shares one session's rates from then on.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, auto

from server.http.errors import TryLater

CLIENTS_MAX = 10_000
"""Clients that a kind remembers; beyond, all begin again: strangers must not fill the memory."""


class TooOften(TryLater):
    """One client asks more often than it may."""

    def __init__(self, rate: "Rate", wait: float) -> None:
        super().__init__(f"{rate.what}: more than {rate.per_second:g} a second from one client; wait {wait:.2g} s")
        self.wait = wait


@dataclass(frozen=True)
class Rate:
    """How many at once, and how many a second in the long run."""

    what: str
    burst: float
    per_second: float


SESSION = Rate("requests", 400, 200)
"""A page that drags, draws and plots makes fewer than 20 a second beside its socket; a script may poll at 100 Hz."""
HEAVY = Rate("heavy requests", 60, 5)
"""All but those that `server/access/light.py` names: they may keep a core or the disk busy for 10 ms to seconds. A page
plans 7 times a second at most, while one draws.
"""
ANONYMOUS = Rate("requests without a session", 300, 20)
"""A page and its scripts are 30; a lab may be behind one address."""
SIGN_IN = Rate("sign-ins", 150, 1)
"""Of one role and address; a class of 100 may come in at once. Those beyond share one client's buckets, and no log has
a line for each.
"""
WRONG_TOKEN = Rate("wrong access tokens", 5, 5 / 60)
"""Of one address; beyond, they are refused as too many."""
MESSAGE = Rate("messages", 600, 300)
"""On sockets: target at the screen's rate (60 to 144 Hz), presence 20 Hz, the camera of a 3D view at the screen's."""
FLOOD = Rate("refused messages", 3000, 300)
"""Beyond `MESSAGE`; who is refused more often than this is not a page that hurries."""
TOLD = Rate("notices", 1, 1)
"""How often a socket is told that its messages are dropped."""
LINE = Rate("lines of the log", 60, 2)
"""What one client is refused, and its commands: more would push out what others did."""
AUDITED = Rate("lines of the audit log", 600, 20)
"""What one session does: it fills the file in no less than an hour."""
STRANGE = Rate("lines of the audit log on strangers", 1, 1 / 60)
"""Refusals of one address: strangers would push everything else out of the file."""


class Bucket:
    """The tokens of every client, as the time when its bucket will be full again (generic cell rate algorithm)."""

    def __init__(self, rate: Rate, factor: float = 1.0, now: Callable[[], float] = time.monotonic) -> None:
        self.rate = Rate(rate.what, rate.burst * factor, rate.per_second * factor)
        self._now = now
        self._full: dict[str, float] = {}

    def wait(self, client: str) -> float:
        """Take a token and return 0, or take none and return the time until there is one [s]."""
        now, apart = self._now(), 1.0 / self.rate.per_second
        full = max(self._full.get(client, now), now) + apart
        late = full - now - self.rate.burst * apart
        if late > 1e-9:
            return late
        if len(self._full) >= CLIENTS_MAX:
            self._full.clear()
        self._full[client] = full
        return 0.0


class Verdict(Enum):
    """What becomes of a message on a socket."""

    HEARD = auto()
    DROPPED = auto()
    REFUSED = auto()
    """Dropped, and the client is told so."""
    FLOOD = auto()
    """The socket is to be closed, with POLICY."""


POLICY = 1008
"""The code with which a socket is closed that is flooded."""


class Rates:
    """A bucket of each kind; `factor` multiplies all limits."""

    def __init__(self, factor: float = 1.0, now: Callable[[], float] = time.monotonic) -> None:
        requests, sockets, tokens = (SESSION, HEAVY, ANONYMOUS), (MESSAGE, FLOOD), (SIGN_IN, WRONG_TOKEN)
        self._session, self._heavy, self._stranger = (Bucket(kind, factor, now) for kind in requests)
        self._message, self._flood = (Bucket(kind, factor, now) for kind in sockets)
        self._sign_in, self._wrong = (Bucket(kind, factor, now) for kind in tokens)
        self._told = Bucket(TOLD, 1.0, now)

    def budget(self, role: str, address: str) -> str:
        """What a new session of `role` from `address` shares with others, where they are opened too fast; else ""."""
        of = f"{role} {address}"
        return f"sessions of {of}" if self._sign_in.wait(of) else ""

    def wrong_token(self, address: str) -> float:
        """One more from there; the time until another one is heard [s], 0 if this one still was."""
        return self._wrong.wait(address)

    def refusal(self, session: str | None, address: str, light: bool) -> TooOften | None:
        """Why this request must wait, None if it need not; the strictest of its kinds decides."""
        buckets = [(self._stranger, address)] if session is None else [(self._session, session)]
        if session is not None and not light:
            buckets.append((self._heavy, session))
        for bucket, client in buckets:
            if wait := bucket.wait(client):
                return TooOften(bucket.rate, wait)
        return None

    @property
    def too_many(self) -> str:
        """Why messages are dropped."""
        return (
            f"messages: more than {self._message.rate.per_second:g} a second from one session; the others are dropped"
        )

    def message(self, client: str) -> Verdict:
        """What becomes of one more message of `client`."""
        if not self._message.wait(client):
            return Verdict.HEARD
        if self._flood.wait(client):
            return Verdict.FLOOD
        return Verdict.DROPPED if self._told.wait(client) else Verdict.REFUSED
