"""Questions to the rig: plain ones, and sealed ones within a session that is opened when it is first needed.

Only a reply that is proven to be the rig's, to this very question, is an answer; all others are as if they never came.
"""

import os
import secrets
import socket
import threading
from collections.abc import Callable
from typing import Any, NamedTuple

import zenoh

from controller.errors import (
    KeyRefused,
    LayoutMismatch,
    ParameterError,
    RigHeld,
    RigUnreachable,
    SessionUnknown,
    TendrilError,
    Unproven,
)
from controller.link.keys import Keys
from controller.link.proof import PROOF_BYTES, Reply, question, read_reply
from controller.link.refusals import Refusals
from controller.link.seal import Introduction, Sealer

TIMEOUT_S = 0.5
"""Longest wait for an answer; the rig itself waits for its loop, 0.4 s at most."""
NONCE_BYTES = 16
_KINDS: dict[str, type[TendrilError]] = {
    kind.__name__: kind for kind in (KeyRefused, SessionUnknown, RigHeld, LayoutMismatch)
}


class Answer(NamedTuple):
    """What the rig answered, and what the proof of it says."""

    payload: bytes
    proof: Reply


class Asker:
    """Asks one rig over the zenoh session `link`. Thread safe; sealed questions on one key leave in order."""

    def __init__(self, link: Any, keys: Keys, key: bytes, urgent: bool = False) -> None:
        """`urgent` questions pass all others on the link."""
        self._quality = {"priority": zenoh.Priority.REAL_TIME, "express": True} if urgent else {}
        self._link, self._keys, self._key = link, keys, key
        self._sealer: Sealer | None = None
        self._lock = threading.Lock()
        self._trouble: TendrilError | None = None
        self._refusals = Refusals(keys.rig, what="reply")

    @property
    def trouble(self) -> TendrilError | None:
        """Why the rig takes nothing from this server, as it said last; None when it does."""
        return self._trouble

    def ask(self, expression: str, payload: bytes = b"", timeout: float = TIMEOUT_S) -> Answer:
        """Answer of the queryable `expression`; RigUnreachable without one, the rig's own error if it refuses."""
        return self._get(expression, payload, secrets.token_bytes(NONCE_BYTES), timeout).answer()

    def ask_sealed(
        self,
        expression: str,
        payload: bytes,
        timeout: float = TIMEOUT_S,
        any_server: bool = False,
        again: bool = False,
    ) -> bytes:
        """The same with a seal. A rig that restarted, or forgot this server, is met and asked `again`, once.

        `any_server`: the rig takes this question from every server, so its answer does not say that `trouble` is over.
        """
        try:
            with self._lock:
                if self._sealer is None:
                    self._sealer = self._opened(timeout)
                asked = self._get(expression, payload, self._sealer.seal(expression, payload), timeout)
            answer = asked.answer().payload
        except TendrilError as error:
            if isinstance(error, SessionUnknown) and not again:
                self.forget()
                return self.ask_sealed(expression, payload, timeout, any_server, again=True)
            self._trouble = error if isinstance(error, tuple(_KINDS.values())) else None
            raise
        if not (any_server and isinstance(self._trouble, RigHeld)):
            self._trouble = None
        return answer

    def send_sealed(self, expression: str, payload: bytes) -> Callable[[], Answer] | None:
        """Send a sealed question without waiting for anything; what then waits for its answer, and raises as `ask`.

        None where it was not sent: it would have had to wait, for another thread or for a session.
        """
        if not self._lock.acquire(blocking=False):
            return None
        try:
            if self._sealer is None:
                return None
            seal = self._sealer.seal(expression, payload)
            return self._get(expression, payload, seal, TIMEOUT_S, zenoh.CongestionControl.DROP).answer
        except RigUnreachable:
            return None
        finally:
            self._lock.release()

    def prepare(self, timeout: float = TIMEOUT_S) -> None:
        """Open the session now, so that the first sealed question needs not wait for it."""
        with self._lock:
            if self._sealer is None:
                self._sealer = self._opened(timeout)

    def forget(self) -> None:
        """Open another session with the next sealed question: the rig restarted."""
        with self._lock:
            self._sealer = self._trouble = None

    def leave(self, timeout: float) -> None:
        """Let another server command the rig at once, if this one did and the rig still answers."""
        if self._sealer is None:
            return
        try:
            self.ask_sealed(self._keys.leave, b"", timeout, again=True)
        except TendrilError:
            pass  # it will notice our silence

    def _opened(self, timeout: float) -> Sealer:
        words = self.ask(self._keys.session, timeout=timeout).payload
        boot, number = int.from_bytes(words[:8], "little"), int.from_bytes(words[8:], "little")
        sealer = Sealer(self._key, boot, number)
        introduction = Introduction(who=f"the server on {socket.gethostname()[:100]} (process {os.getpid()})")
        payload = introduction.model_dump_json().encode()
        expression = self._keys.session
        self._get(expression, payload, sealer.seal(expression, payload), timeout).answer()
        return sealer

    def _get(
        self,
        expression: str,
        payload: bytes,
        attachment: bytes,
        timeout: float,
        full: Any = zenoh.CongestionControl.BLOCK,
    ) -> "_Asked":
        """Send the question to all who may answer it; the replies come while they are read, none instead of another.

        `full`: what becomes of it where the link takes no more.
        """
        try:
            replies = self._link.get(
                expression,
                target=zenoh.QueryTarget.ALL,
                consolidation=zenoh.ConsolidationMode.NONE,
                payload=payload,
                attachment=attachment,
                timeout=timeout,
                congestion_control=full,
                **self._quality,
            )
        except zenoh.ZError as error:
            raise RigUnreachable(f"rig {self._keys.rig!r} cannot be asked: {error}") from error
        asked = question(attachment, payload)
        return _Asked(replies, self._key, self._keys.rig, expression, asked, timeout, self._refusals)


class _Asked(NamedTuple):
    """A question that was sent."""

    replies: Any
    key: bytes
    rig: str
    expression: str
    question: bytes
    timeout: float
    refusals: Refusals

    def answer(self) -> Answer:
        """The first reply that is the rig's; its own error if it refuses, RigUnreachable without one."""
        false = 0
        for reply in self.replies:
            if not reply.ok:  # zenoh's own, such as a timeout: the rig's refusals bear a proof
                continue
            try:
                answer = self._proven(reply.ok)
            except Unproven as error:
                false += 1
                self.refusals.note(self.expression, error)
                continue
            if kind := answer.proof.kind:
                raise _KINDS.get(kind, ParameterError)(answer.payload.decode())
            return answer
        others = f"; {false} replies did not bear the proof of its key" if false else ""
        raise RigUnreachable(f"rig {self.rig!r} did not answer within {self.timeout:g} s{others}")

    def _proven(self, reply: Any) -> Answer:
        attachment = b"" if reply.attachment is None else reply.attachment.to_bytes()[: PROOF_BYTES + 1]
        payload = reply.payload.to_bytes()
        return Answer(payload, read_reply(self.key, self.expression, self.question, attachment, payload))
