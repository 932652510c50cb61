"""The E-STOP's lane to the rig: a thread of its own, which waits for no command, permit, lock or queue of others.

Who presses sends it at once, before this thread gets its turn, for which it would wait under a flood. The thread waits
for the answer, and sends what could not be sent at once.

An E-STOP that is not answered is sent again, with the same number, until the rig answers, in this life or in its next;
the rig acts on it once. Who asks while one is on its way gets another one of its own: the first may have been cleared
meanwhile.
"""

import secrets
import threading
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress

from controller.errors import RigUnreachable, SessionUnknown, TendrilError
from controller.schema.messages import CommandReply
from controller.system.thread import SupervisedThread

AGAIN = 0.05
"""Pause before an E-STOP that was not answered is sent again [s]."""
LAST = 2.0
"""Longest wait for the one that is under way at the end [s]."""


class Stopper:
    """Sends E-STOPs. `boot` is the rig's boot that was met last, None before the first contact."""

    def __init__(
        self,
        send: Callable[[int, int, str], CommandReply],
        boot: Callable[[], int | None],
        at_once: Callable[[int, int, str], Callable[[], CommandReply] | None] = lambda number, boot, by: None,
    ) -> None:
        """`send` is `RigClient.stop`, `at_once` its `send_stop`."""
        self._send, self._boot, self._at_once = send, boot, at_once
        self._number = secrets.randbits(62)
        self._asked: list[Future[CommandReply]] = []
        self._meant: int | None = None
        """The boot of the rig that was known at the last press."""
        self._waiting: tuple[int, int] | None = None
        """Number and boot of the one that was not answered yet."""
        self._sent: tuple[tuple[int, int], Callable[[], CommandReply]] | None = None
        """Number and boot of the last one that left at once, and what waits for its answer; None once it was heard."""
        self._passed: tuple[int | None, int] = (None, 0)
        self._wake = threading.Condition()
        self._closed = False
        self.by = ""
        """Who pressed first since the rig was last known to be in no E-STOP, "" for no one here."""
        self.worker = SupervisedThread("e-stop", self._run)
        self.worker.start()

    @property
    def waits(self) -> bool:
        """An E-STOP was asked for, and no rig has answered it."""
        return bool(self._asked or self._waiting)

    def passed(self, boot: int) -> int:
        """The number that the last E-STOP took in this boot of the rig: what is asked later must be above it."""
        known, number = self._passed
        return number if known == boot else 0

    def stop(self, who: str = "") -> "Future[CommandReply]":
        """Ask now, for `who`; RigUnreachable where no answer came at once, but it is sent until there is one."""
        answer: Future[CommandReply] = Future()
        answer.set_running_or_notify_cancel()
        with self._wake:
            self.by = self.by or who
            if self._closed:
                answer.set_exception(RigUnreachable("the server is shutting down"))
                return answer
            self._number += 1
            number, meant, by = self._number, self._boot(), self.by
        sent = None if meant is None else self._at_once(number, meant, by)
        with self._wake:
            if number == self._number:  # else another press came meanwhile, which is answered for both
                self._meant = meant
                self._sent = None if meant is None or sent is None else ((number, meant), sent)
            self._asked.append(answer)
            self._wake.notify()
        return answer

    def over(self, by: str = "") -> None:
        """The rig has left its E-STOP, or is another one: who presses next is the first, unless it begins stopped,
        `by` whom an earlier life of it was.
        """
        self.by = by

    def close(self) -> None:
        """End; who waits is told."""
        with self._wake:
            self._closed = True
            self._wake.notify()
        self.worker.stop(LAST)

    def _run(self) -> None:
        while True:
            self.worker.rest()
            with self._wake:
                self._wake.wait_for(lambda: self._asked or self._closed, AGAIN if self._waiting else None)
                answers, self._asked = self._asked, []
                if answers:
                    self._begin()
                if self._closed:
                    return _fail(answers, RigUnreachable("the server is shutting down"))
            self.worker.turn()
            self._serve(answers)

    def _begin(self) -> None:
        """Another press: it has a number of its own, and is for the boot that was known when it was asked."""
        self._waiting = None if self._meant is None else (self._number, self._meant)

    def _serve(self, answers: "list[Future[CommandReply]]") -> None:
        waiting = self._waiting
        if waiting is None:
            return _fail(answers, RigUnreachable("the rig does not answer: it was not heard yet"))
        number, boot = waiting
        if (
            met := self._boot()
        ) is not None and met != boot:  # nobody answered for its earlier life: it is meant as well
            boot = met
            self._waiting = (number, met)
        try:
            reply = self._answer(number, boot)
        except Exception as error:
            text = str(error) if isinstance(error, TendrilError) else f"it could not be sent: {error}"
            return _fail(answers, RigUnreachable(f"{text}; the E-STOP is sent again until the rig answers"))
        if reply.accepted:
            self._passed, self._waiting = (boot, reply.n), None
        for answer in answers:
            answer.set_result(reply)

    def _answer(self, number: int, boot: int) -> CommandReply:
        """Of the one that left at once, if this is its first time; else it is sent."""
        sent, self._sent = self._sent, None
        if sent is not None and sent[0] == (number, boot):
            with suppress(SessionUnknown):  # the rig forgot this server, and acted on nothing
                return sent[1]()
        return self._send(number, boot, self.by)


def _fail(answers: "list[Future[CommandReply]]", error: TendrilError) -> None:
    for answer in answers:
        answer.set_exception(error)
