"""Who is told that the rig took a request may look at once: the answer waits for the row of telemetry that shows it.

The rig's reply comes by a lane of its own and is there before that row, by a batch and more. Without the wait the next
thing that is asked of the server, a run right after an ARM, is judged by a state that is over.
"""

import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import NamedTuple

from controller.arrays import Rows
from controller.schema.messages import CommandReply

LONGEST = 0.5
"""Wait for that row [s]; then the answer is given all the same: of telemetry that does not come the page is told."""
LOOK = 2e-3
"""From one look at the newest row to the next, while an answer waits [s]."""


class _Answer(NamedTuple):
    reply: CommandReply
    askers: "list[Future[CommandReply]]"
    boot: int | None
    request_n: int
    until: float

    def shown(self, boot: int | None, newest: Rows | None) -> bool:
        if boot != self.boot or newest is None or time.monotonic() > self.until:
            return True
        return int(newest[0]["request_n"]) >= self.request_n

    def give(self) -> None:
        for asker in self.askers:
            asker.set_result(self.reply)


class Shown:
    """Answers of one thread, which calls `look` every `LOOK` seconds while there are `any`."""

    def __init__(self, boot: Callable[[], int | None], newest: Callable[[], Rows | None]) -> None:
        """`boot` of the rig that is connected, and its `newest` row, as the rest of the server sees them."""
        self._boot, self._newest = boot, newest
        self._answers: list[_Answer] = []

    def __bool__(self) -> bool:
        """Whether an answer waits."""
        return bool(self._answers)

    def give(self, reply: CommandReply, askers: "list[Future[CommandReply]]", boot: int | None, request_n: int) -> None:
        """`reply` to `askers` once a row of `boot` has `request_n`; request_n = 0 or a refusal: now."""
        taken = request_n if reply.accepted else 0
        self._answers.append(_Answer(reply, askers, boot, taken, time.monotonic() + LONGEST))
        self.look()

    def look(self, *, all_of_them: bool = False) -> None:
        """Give what is shown by now, or everything at the end."""
        boot, newest = self._boot(), self._newest()
        waiting, self._answers = self._answers, []
        for answer in waiting:
            if all_of_them or answer.shown(boot, newest):
                answer.give()
            else:
                self._answers.append(answer)
