"""What any thread hands to the recorder's thread: rows, of which the newest are kept in memory, and things to do."""

import queue
import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import TypeVar

from recordings.before import Before, Rows

QUEUE_BATCHES = 6000
"""A minute of batches at 100 Hz. A full queue makes the link wait, which then refills its gap from the rig's ring."""

T = TypeVar("T")
Job = Callable[[], object]


class Intake:
    """One queue, in the order in which things came. Rows are queued while it is open, and kept at any time."""

    def __init__(self) -> None:
        self.is_open = False
        self._before = Before()
        self._queue: queue.Queue[Job | Rows | None] = queue.Queue(QUEUE_BATCHES)
        self._hand_over = threading.Lock()
        """Held while rows go to memory and queue, and while a recording takes those in memory: none is lost between."""

    def rows(self, rows: Rows) -> None:
        """Take rows (n,), n >= 1, which nobody changes any more."""
        with self._hand_over:
            self._before.add(rows)
            if self.is_open:
                self._queue.put(rows)

    def open(self, after: int) -> list[Rows]:
        """Queue all that comes from now on; the batches in memory after the tick `after` are what came before it."""
        with self._hand_over:
            self.is_open = True
            return self._before.since(after)

    def later(self, job: Job | None) -> None:
        """Let `job` be done after all that was handed over before; None is the end."""
        self._queue.put(job)

    def ask(self, work: Callable[[], T]) -> T:
        """Let `work` be done after all that was handed over before, and wait for its result or its error."""
        answer: Future[T] = Future()

        def job() -> None:
            try:
                answer.set_result(work())
            except Exception as error:
                answer.set_exception(error)

        self._queue.put(job)
        return answer.result()

    def next(self, timeout: float | None) -> Job | Rows | None:
        """What was handed over next, None at the end; raises `queue.Empty` when nothing comes within `timeout` [s]."""
        return self._queue.get(timeout=timeout)
