"""What is asked of the rig, and how its askers are answered: by the row of telemetry that shows what came of it.

The rig's reply says what its tick made of a request, and passes that row by a batch and more. Without the wait for it
the next thing that is asked of the server, a run right after an ARM, would be judged by a state that is over.
"""

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field
from typing import NamedTuple

from controller.arrays import Rows
from controller.errors import TendrilError
from controller.schema.messages import CommandReply
from controller.schema.modes import Request
from controller.schema.parameters import Settings
from server.access.permit import Permit

SHOWN_MAX_S = 0.5
"""Longest wait for that row; then the answer is given all the same: a page is told of telemetry that does not come."""

Target = tuple[float, float]


@dataclass
class Job:
    """Fields to change in the command, and everyone who waits for the rig's answer to it."""

    permit: Permit | None = None
    """None: it only repeats."""
    request: Request = Request.NONE
    target: Target | None = None
    settings: Settings | None = None
    boot: int | None = None
    """Boot id of the rig that the asker saw; None where it was silent just then."""
    stops: int = 0
    """How many E-STOPs were asked for at this server before it."""
    used: int = 0
    """The highest request number that the rig was known to have used when it was asked for."""
    askers: list["Future[CommandReply]"] = field(default_factory=list)

    @property
    def moves_only(self) -> bool:
        """A newer target may take this job's place."""
        return self.request == Request.NONE and self.settings is None and self.target is not None

    @property
    def moves(self) -> bool:
        """The rig may move by it."""
        return self.request in (Request.FOLLOW, Request.TRACK) or self.moves_only

    def answer(self, reply: CommandReply) -> None:
        """Tell every asker what the rig made of it."""
        for asker in self.askers:
            asker.set_result(reply)

    def fail(self, error: TendrilError) -> None:
        """Tell every asker that the command did not go out, or was not answered."""
        for asker in self.askers:
            if not asker.done():
                asker.set_exception(error)


class _Waiting(NamedTuple):
    job: Job
    reply: CommandReply
    boot: int | None
    request_n: int
    until: float

    def waits(self, boot: int | None, request_n: int, now: float) -> bool:
        """Whether its row has not come, and may still."""
        return self.boot == boot and self.request_n > request_n and now <= self.until


class Acknowledgements:
    """Requests that the rig took, each until its row has come. Thread safe."""

    def __init__(self, boot: Callable[[], int | None], newest: Callable[[], Rows | None]) -> None:
        """`boot` of the rig that is connected, and its `newest` row, as the rest of the server sees them."""
        self._boot, self._newest = boot, newest
        self._waiting: list[_Waiting] = []
        self._lock = threading.Lock()

    def add(self, job: Job, reply: CommandReply, boot: int | None, request_n: int) -> None:
        """Answer `job` once a row of `boot` has `request_n`."""
        with self._lock:
            self._waiting.append(_Waiting(job, reply, boot, request_n, time.monotonic() + SHOWN_MAX_S))
        self.look()

    def look(self, *, all_of_them: bool = False) -> None:
        """Answer what is shown by now, or everything at the end; called as rows come, and for what waits in vain."""
        if not self._waiting:
            return
        boot, newest, now = self._boot(), self._newest(), time.monotonic()
        shown = 2**62 if all_of_them or newest is None else int(newest[0]["request_n"])
        with self._lock:
            answered = [one for one in self._waiting if not one.waits(boot, shown, now)]
            self._waiting = [one for one in self._waiting if one.waits(boot, shown, now)]
        for one in answered:
            one.job.answer(one.reply)
