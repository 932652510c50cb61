"""The seal: proof that a message which changes the rig comes from a server with the rig's key, and comes once.

It travels as the attachment of a query, little endian:

    int64 session | int64 count | 32 bytes HMAC-SHA256

    HMAC-SHA256 over: b"tendril seal 1", int64 boot id, int64 session, int64 count, key expression, zero byte, payload

- The boot id is part of what is signed, so a recorded message is worth nothing in another boot of the rig.
- The session is a number that the rig hands out to all who ask. Opening one is itself a sealed message, and takes the
  number whether or not it helps: a recorded opening cannot be sent again.
- The count rises strictly within a session and key expression: no message is taken twice, or after a later one.
- The key expression is signed too: a command is no reference. Keys are compared in constant time.

What only reads (replay, info) bears a random number instead, to which the reply is bound: what the rig says is proven
in the other direction (proof.py). Nothing is encrypted: docs/two-machines.md.
"""

import hmac
import secrets
import struct
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Annotated

from pydantic import Field as Bounds
from pydantic import ValidationError

from controller.errors import KeyRefused, ParameterError, RigHeld, SessionUnknown, sentence
from controller.link.proof import Prover
from controller.link.version import LAYOUT, OURS, require_same
from controller.schema.layout import Model

SESSIONS_MAX = 32
"""Sessions that the rig remembers, two a server (its commands, its E-STOPs); the one silent longest is forgotten."""
SILENT_S = 2.0
"""Silence after which another server may command; the rig itself holds long before, at `server_hold`."""
_DOMAIN = b"tendril seal 1"
_HEAD = struct.Struct("<qq")
_MAC_BYTES = 32
SEAL_BYTES = _HEAD.size + _MAC_BYTES


class Introduction(Model):
    """Who opens a session."""

    who: Annotated[str, Bounds(max_length=200)]
    """Machine and process, as an operator at another server is told them."""
    version: str = OURS
    layout: str = LAYOUT


@dataclass(frozen=True)
class Sealer:
    """The server's side of one session with one boot of the rig."""

    key: bytes
    boot: int
    session: int
    counts: dict[str, int] = field(default_factory=dict)

    def seal(self, expression: str, payload: bytes) -> bytes:
        """The attachment for the next message on `expression`; messages must leave in the order of the calls."""
        count = self.counts[expression] = self.counts.get(expression, 0) + 1
        head = _HEAD.pack(self.session, count)
        return head + _mac(self.key, self.boot, head, expression, payload)


@dataclass(frozen=True)
class SealedSession:
    """A server that the rig has met, and the last count it used on each key expression."""

    number: int
    who: str
    counts: dict[str, int] = field(default_factory=dict)


class Seals:
    """The rig's side: opens sessions in one boot of the rig and judges every sealed message. Thread safe."""

    def __init__(self, key: bytes, boot: int, file: str) -> None:
        """`file` holds the key and is named to those who have another one."""
        self.boot = boot
        self.prover = Prover(key, boot)
        """What the rig says is proven by the same key."""
        self._key, self._file = key, file
        self._next = secrets.randbits(61)  # not 1: a session of the last boot must not be known in this one
        self._sessions: dict[int, SealedSession] = {}
        self._lock = threading.Lock()

    @property
    def next_session(self) -> int:
        """The number under which the next session is to be opened."""
        return self._next

    def open(self, expression: str, payload: bytes, seal: bytes) -> SealedSession:
        """Open the session whose Introduction is `payload`; refuses another layout than ours with LayoutMismatch."""
        with self._lock:
            number, _ = self._verified(expression, payload, seal)
            if number != self._next:
                raise SessionUnknown(f"session {number} cannot be opened any more: ask the rig for the next number")
            self._next += 1
            return self._introduced(number, payload)

    def admit(self, expression: str, payload: bytes, seal: bytes) -> SealedSession:
        """The session that sealed this message; KeyRefused unless the key is ours and the message a new one."""
        with self._lock:
            number, count = self._parsed(seal)
            session = self._sessions.get(number)
            if session is None:
                raise SessionUnknown(f"refused: no session {number} is open; open one with the key of {self._file}")
            self._verified(expression, payload, seal)
            if count <= (last := session.counts.get(expression, 0)):
                raise KeyRefused(f"refused: count {count} of this session is not above {last}, so it was sent before")
            session.counts[expression] = count
            self._sessions[number] = self._sessions.pop(number)  # newest last
            return session

    def _introduced(self, number: int, payload: bytes) -> SealedSession:
        try:
            by = Introduction.model_validate_json(payload)
        except ValidationError as error:
            raise ParameterError(f"introduction: {sentence(error)}") from error
        require_same(by.who, by.version, by.layout, "this rig")
        session = self._sessions[number] = SealedSession(number, by.who)
        while len(self._sessions) > SESSIONS_MAX:
            del self._sessions[next(iter(self._sessions))]
        return session

    def _parsed(self, seal: bytes) -> tuple[int, int]:
        if len(seal) != SEAL_BYTES:
            raise KeyRefused(
                f"refused: a seal of {len(seal)} bytes is not one of {SEAL_BYTES}; "
                f"only servers with the rig's key, in {self._file} on its machine, may change anything"
            )
        number, count = _HEAD.unpack_from(seal)
        return number, count

    def _verified(self, expression: str, payload: bytes, seal: bytes) -> tuple[int, int]:
        """Session and count of a seal made with our key in this boot."""
        found = self._parsed(seal)
        head, mac = seal[: _HEAD.size], seal[_HEAD.size :]
        if not hmac.compare_digest(mac, _mac(self._key, self.boot, head, expression, payload)):
            raise KeyRefused(
                f"refused: sealed with another key than the rig's: copy {self._file} from its machine, "
                "and give it to the server as --key-file"
            )
        return found


class Holder:
    """Which of several servers commands the rig: the first that asks, until it leaves or was silent for SILENT_S.

    Asked with every sealed message but an E-STOP, which is taken from any server that has the key. Thread safe.
    """

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._session: SealedSession | None = None
        self._since, self._heard = "", 0.0
        self._lock = threading.Lock()

    def take(self, session: SealedSession) -> None:
        """`session` commands from here on, or still; RigHeld names who does instead, and since when."""
        with self._lock:
            if self._session is not None and session.number != self._session.number:
                if self._now() - self._heard < SILENT_S:
                    raise RigHeld(
                        f"refused: {self._session.who} commands this rig since {self._since} (its clock); "
                        f"stop that server, or cut it off for {SILENT_S:g} s"
                    )
                self._session = None
            if self._session is None:
                self._session, self._since = session, time.strftime("%Y-%m-%d %H:%M:%S")
            self._heard = self._now()

    def leave(self, session: SealedSession) -> None:
        """`session` commands no longer, if it did: the next one may at once."""
        with self._lock:
            if self._session is not None and self._session.number == session.number:
                self._session = None


def _mac(key: bytes, boot: int, head: bytes, expression: str, payload: bytes) -> bytes:
    message = b"".join((_DOMAIN, boot.to_bytes(8, "little"), head, expression.encode(), b"\0", payload))
    return hmac.digest(key, message, "sha256")
