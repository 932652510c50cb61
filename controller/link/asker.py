"""Questions to the rig: plain ones, and sealed ones within a session that is opened when it is first needed."""

import os
import socket
import threading
from typing import Any

import zenoh

from controller.errors import (
    KeyRefused,
    LayoutMismatch,
    ParameterError,
    RigHeld,
    RigUnreachable,
    SessionUnknown,
    TendrilError,
)
from controller.link.keys import Keys
from controller.link.seal import Introduction, Sealer

TIMED_OUT = "Timeout"
"""What zenoh itself puts into an error reply when nobody answered in time."""
TIMEOUT = 0.5
"""Longest wait for an answer [s]; the rig itself waits for its loop, 0.4 s at most."""
_KINDS: dict[str, type[TendrilError]] = {
    kind.__name__: kind for kind in (KeyRefused, SessionUnknown, RigHeld, LayoutMismatch)
}


class Asker:
    """Asks one rig over the zenoh session `link`. Thread safe; sealed questions on one key leave in order."""

    def __init__(self, link: Any, keys: Keys, key: bytes | None) -> None:
        """`key` None: everything can be read, nothing changed."""
        self._link, self._keys, self._key = link, keys, key
        self._sealer: Sealer | None = None
        self._lock = threading.Lock()
        self._trouble: TendrilError | None = None

    @property
    def trouble(self) -> TendrilError | None:
        """Why the rig takes nothing from this server, as it said last; None when it does."""
        return self._trouble

    def ask(self, expression: str, payload: bytes = b"", timeout: float = TIMEOUT) -> bytes:
        """Answer of the queryable `expression`; RigUnreachable without one, the rig's own error if it refuses."""
        return self._answer(self._get(expression, payload, timeout), timeout)

    def ask_sealed(self, expression: str, payload: bytes, timeout: float = TIMEOUT, any_server: bool = False) -> bytes:
        """The same with a seal. A rig that restarted, or forgot this server, is met anew.

        `any_server`: the rig takes this question from every server, so its answer does not say that `trouble` is over.
        """
        try:
            try:
                answer = self._ask_sealed(expression, payload, timeout)
            except SessionUnknown:
                self.forget()
                answer = self._ask_sealed(expression, payload, timeout)
        except TendrilError as error:
            self._trouble = error if isinstance(error, tuple(_KINDS.values())) else None
            raise
        if not (any_server and isinstance(self._trouble, RigHeld)):
            self._trouble = None
        return answer

    def forget(self) -> None:
        """Open another session with the next sealed question: the rig restarted."""
        with self._lock:
            self._sealer = self._trouble = None

    def leave(self, timeout: float) -> None:
        """Let another server command the rig at once, if this one did and the rig still answers."""
        if self._sealer is None:
            return
        try:
            self._ask_sealed(self._keys.leave, b"", timeout)
        except TendrilError:
            pass  # it will notice our silence

    def _ask_sealed(self, expression: str, payload: bytes, timeout: float) -> bytes:
        with self._lock:
            if self._sealer is None:
                self._sealer = self._opened(timeout)
            replies = self._get(expression, payload, timeout, self._sealer.seal(expression, payload))
        return self._answer(replies, timeout)

    def _opened(self, timeout: float) -> Sealer:
        if self._key is None:
            raise KeyRefused("this end was given no key of the rig: it can read and nothing else")
        words = self.ask(self._keys.session, timeout=timeout)
        boot, number = int.from_bytes(words[:8], "little"), int.from_bytes(words[8:], "little")
        sealer = Sealer(self._key, boot, number)
        introduction = Introduction(who=f"the server on {socket.gethostname()[:100]} (process {os.getpid()})")
        payload = introduction.model_dump_json().encode()
        expression = self._keys.session
        self._answer(self._get(expression, payload, timeout, sealer.seal(expression, payload)), timeout)
        return sealer

    def _get(self, expression: str, payload: bytes, timeout: float, seal: bytes | None = None) -> Any:
        """Send the question; the replies come while they are read."""
        try:
            return self._link.get(expression, payload=payload, attachment=seal, timeout=timeout)
        except zenoh.ZError as error:
            raise RigUnreachable(f"rig {self._keys.rig!r} cannot be asked: {error}") from error

    def _answer(self, replies: Any, timeout: float) -> bytes:
        for reply in replies:
            if reply.ok:
                return bytes(reply.ok.payload.to_bytes())
            text = reply.err.payload.to_string()
            if text != TIMED_OUT:
                raise _KINDS.get(str(reply.err.encoding).partition(";")[2], ParameterError)(text)
        raise RigUnreachable(f"rig {self._keys.rig!r} did not answer within {timeout:g} s")
