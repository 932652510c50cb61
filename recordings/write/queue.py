"""What any thread hands to the recorder's thread: rows, of which the newest are kept in memory, and things to do.

Handing over never waits: behind a disk that hangs the link must go on, and the event loop with it.
"""

import queue
import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from typing import TypeVar

from controller.arrays import Rows
from controller.errors import RecordingError

PRE_TRIGGER_ROWS = 10_000
"""Rows in memory: 10 s at 1 kHz, some 10 MB."""
QUEUE_BATCHES = 36_000
"""Ten minutes of batches at 60 Hz, 570 MB at 1 kHz. A recording whose queue is full has lost rows, and ends."""
BEHIND_BATCHES = 120
"""Two seconds of them: with more in the queue the disk is still to catch up."""
QUEUE_JOBS = 500
"""Lines of the log and the like that may wait; what comes beyond them is left out, and counted."""


class NoAnswer(RecordingError):
    """The recorder's thread did not come to it in time."""


T = TypeVar("T")
Job = Callable[[], object]


class PreTrigger:
    """The newest rows, for a recording that begins before its button was pressed; not thread-safe.

    Batches of one boot of the rig, with `most` rows at most.
    """

    def __init__(self, most: int = PRE_TRIGGER_ROWS) -> None:
        self._batches: deque[Rows] = deque()
        self._most, self._count = most, 0

    def add(self, rows: Rows) -> None:
        """Keep `rows` (n,), n >= 1, which no one changes any more; rows of an earlier boot are dropped."""
        if self._batches and rows["tick"][0] <= self._batches[-1]["tick"][-1]:
            self._batches.clear()
            self._count = 0
        self._batches.append(rows)
        self._count += len(rows)
        while self._count - len(self._batches[0]) >= self._most:
            self._count -= len(self._batches.popleft())

    def since(self, tick: int) -> list[Rows]:
        """The rows after `tick`, the newest `most` of them, as batches."""
        if not self._count:
            return []
        first = max(tick, int(self._batches[-1]["tick"][-1]) - self._most)
        later = (batch[batch["tick"] > first] for batch in self._batches)
        return [batch for batch in later if len(batch)]


class RecorderQueue:
    """One queue, in the order in which things came. Rows are queued while it is open, and kept at any time."""

    def __init__(self, batches: int = QUEUE_BATCHES, jobs: int = QUEUE_JOBS) -> None:
        self.is_open = False
        self.full = False
        """Whether rows were lost since it was opened."""
        self.left_out = 0
        """Jobs that were left out since the count was last put back to 0."""
        self._pre_trigger = PreTrigger()
        self._batches, self._jobs = batches, jobs
        self._queue: queue.SimpleQueue[Job | Rows | None] = queue.SimpleQueue()
        self._hand_over = threading.Lock()
        """Held while rows go to memory and queue, and while a recording takes those in memory: none is lost between."""

    def rows(self, rows: Rows) -> None:
        """Take rows (n,), n >= 1, which no one changes any more."""
        with self._hand_over:
            self._pre_trigger.add(rows)
            if not self.is_open:
                return
            if self._queue.qsize() < self._batches:
                self._queue.put(rows)
            else:
                self.is_open, self.full = False, True

    @property
    def behind(self) -> bool:
        """Whether what waits is more than a moment's."""
        return self._queue.qsize() > BEHIND_BATCHES

    def open(self, after: int) -> list[Rows]:
        """Queue all that comes from now on; the batches in memory after the tick `after` are what came before it."""
        with self._hand_over:
            self.is_open, self.full = True, False
            return self._pre_trigger.since(after)

    def drop(self) -> None:
        """Take no more rows, and forget those that wait; what is to be done is still done."""
        with self._hand_over:
            self.is_open = False
            for _ in range(self._queue.qsize()):
                try:
                    item = self._queue.get_nowait()
                except queue.Empty:
                    return
                if item is None or callable(item):
                    self._queue.put(item)

    def later(self, job: Job) -> bool:
        """Let `job` be done after all that was handed over before; False, and left out, where too many wait."""
        if self._queue.qsize() >= self._batches + self._jobs:
            self.left_out += 1
            return False
        self._queue.put(job)
        return True

    def end(self) -> None:
        """Nothing comes after this."""
        self._queue.put(None)

    def ask(self, work: Callable[[], T], timeout: float) -> T:
        """Let `work` be done after all that was handed over before, and wait for its result or its error.

        NoAnswer after `timeout` [s]; what has not begun by then is never done.
        """
        answer: Future[T] = Future()

        def job() -> None:
            if not answer.set_running_or_notify_cancel():
                return
            try:
                answer.set_result(work())
            except Exception as error:
                answer.set_exception(error)

        self._queue.put(job)
        try:
            return answer.result(timeout)
        except TimeoutError as error:
            answer.cancel()
            raise NoAnswer(f"the disk does not answer: nothing came of it within {timeout:g} s") from error

    def next(self, timeout: float | None) -> Job | Rows | None:
        """What was handed over next, None at the end; raises `queue.Empty` when nothing comes within `timeout` [s]."""
        return self._queue.get(timeout=timeout)
