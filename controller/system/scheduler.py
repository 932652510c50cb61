"""What the event loop does by itself: jobs with a period each, tasks that are not awaited, calls from other threads.

A job that fails ends no other: it is logged, told (`server/health/monitor.py`), and called again when it is due.
"""

import asyncio
import contextvars
import logging
import threading
import time
from collections.abc import Callable, Coroutine
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, TypeVar

from controller.system.loop_watchdog import LoopWatchdog

log = logging.getLogger(__name__)

FAILURE_FORGOTTEN_S = 60.0
"""A failure that does not come again for so long is forgotten, and news if it does."""
EARLY_MAX_S = 0.02
"""A job is called so much before it is due at most, along with others: each wake of the loop costs."""
TASKS_MAX = 100
"""Tasks of one name at a time: what begins more without end has a mistake in it."""

T = TypeVar("T")


@dataclass
class Failure:
    """One kind of failure of one call."""

    text: str
    count: int
    last: float


class ErrorGuard:
    """Named calls. A failure is logged with its traceback once for every kind, and counted after that."""

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._failures: dict[tuple[str, type[BaseException]], Failure] = {}

    def do(self, name: str, call: Callable[[], T]) -> T | None:
        """What it gives; None where it failed."""
        try:
            return call()
        except Exception as error:
            self._note(name, error)
            return None

    @property
    def troubles(self) -> list[str]:
        """What failed within the last minute, and how often."""
        self._forget()
        return [failure.text + f", {failure.count} times" * (failure.count > 1) for failure in self._failures.values()]

    @property
    def failing(self) -> list[str]:
        """The same as kinds, which change less often than their counts."""
        self._forget()
        return [failure.text for failure in self._failures.values()]

    def _note(self, name: str, error: Exception) -> None:
        kind, now = (name, type(error)), self._now()
        known = self._failures.get(kind)
        if known is None:
            text = f"{name} fails: {type(error).__name__}: {error}"[:300]
            self._failures[kind] = Failure(text, 1, now)
            log.error("%s; it is tried again", text, exc_info=error)
        else:
            known.count, known.last = known.count + 1, now

    def _forget(self) -> None:
        now = self._now()
        for kind, failure in list(self._failures.items()):
            if now - failure.last > FAILURE_FORGOTTEN_S:
                log.warning("%s: no more, after %d times", failure.text, failure.count)
                del self._failures[kind]


@dataclass
class Job:
    """A call that is made every `period` [s], and not within `apart` [s] of the last one where it is hastened."""

    name: str
    call: Callable[[], object]
    period: float
    apart: float
    due: float = 0.0
    last: float = 0.0

    @property
    def early(self) -> float:
        """From when on it may be called [s on the monotonic clock]."""
        return max(self.due - min(EARLY_MAX_S, 0.25 * self.period), self.last + self.apart)

    def called(self, now: float) -> None:
        """It is called now: a call that came early keeps the pace, one that is late is not made up for."""
        self.last, self.due = now, max(self.due, now) + self.period


class Scheduler:
    """All that runs in one event loop. `every`, `hasten` and `start` belong to its thread; `soon`, `in_turn` to any."""

    def __init__(self, deadly: Callable[[], None] | None = None) -> None:
        """`deadly` is called where the event loop does not turn any more; see `LoopWatchdog`."""
        self.guard, self.watchdog = ErrorGuard(), LoopWatchdog(deadly)
        self.jobs: dict[str, Job] = {}
        self._loop: asyncio.AbstractEventLoop | None = None
        self._thread = 0
        self._context = contextvars.copy_context()
        self._timer: asyncio.TimerHandle | None = None
        self._before: list[Callable[[], object]] = []
        """Calls that were wanted before the start."""
        self._turned = time.monotonic()
        self._stopped = False
        self._tasks: set[asyncio.Task[Any]] = set()
        self.tell: Callable[[str], object] = lambda text: None
        """Hears what ends a task that is not awaited."""

    def every(self, period: float, name: str, call: Callable[[], object], apart: float = 0.0) -> None:
        """Make `call` every `period` [s] from the start on."""
        self.jobs[name] = Job(name, call, period, apart)

    def hasten(self, *names: str) -> None:
        """Make the next call of these jobs as soon as it may be."""
        for job in (self.jobs[name] for name in names if name in self.jobs):
            job.due = min(job.due, job.last + job.apart)
        self._arm()

    def soon(self, call: Callable[[], object]) -> None:
        """Make `call` in the event loop, behind those that were asked for before; from any thread."""
        if self._loop is None:
            return self._before.append(call)
        if self._stopped:
            return
        with suppress(RuntimeError):  # the loop is closed: the process ends
            self._loop.call_soon_threadsafe(call, context=self._context)

    def in_turn(self, call: Callable[[], object]) -> None:
        """Make `call` at once where this is the event loop, or it has not begun; from any other thread, soon."""
        if self._loop is None or threading.get_ident() == self._thread:
            call()
        else:
            self.soon(call)

    def begin(self, what: str, work: Coroutine[Any, Any, None]) -> None:
        """Do `work`, which is called `what`: kept until it is done, and what ends it is logged and told."""
        if (waiting := sum(task.get_name() == what for task in self._tasks)) >= TASKS_MAX:
            work.close()
            self.tell(f"{what} was left out: {waiting} such tasks wait already")
            return
        self._task(what, work).add_done_callback(self._done)

    async def to_its_end(self, what: str, work: Coroutine[Any, Any, T]) -> T:
        """What comes of `work`, which goes on to its end though who waits for it here is cancelled."""
        task = self._task(what, work)
        try:
            return await asyncio.shield(task)
        except asyncio.CancelledError:
            task.add_done_callback(self._done)  # what becomes of it would be lost
            raise

    def start(self) -> None:
        """Begin, in the running loop."""
        # Not in the context of a request that hastens something: its audit would hear of all that follows.
        self._loop, self._context = asyncio.get_running_loop(), contextvars.copy_context()
        self._thread = threading.get_ident()
        self.watchdog.start()
        for call in self._before:
            self.soon(call)
        self._turn()

    def stop(self, timeout: float = 0.0) -> bool:
        """Call nothing any more."""
        self._stopped = True
        self.jobs.clear()
        self.watchdog.stop()
        if self._timer is not None:
            self._timer.cancel()
        return True

    @property
    def age(self) -> float:
        """Time since jobs were called last [s]."""
        return time.monotonic() - self._turned

    @property
    def trouble(self) -> str:
        """What is wrong with the loop or fails in it, "" if nothing is."""
        return "; ".join([*([self.watchdog.trouble] if self.watchdog.trouble else []), *self.guard.failing])

    def _task(self, what: str, work: Coroutine[Any, Any, T]) -> asyncio.Task[T]:
        task = asyncio.create_task(work, name=what)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    def _done(self, task: "asyncio.Task[Any]") -> None:
        if task.cancelled() or (error := task.exception()) is None:
            return
        log.error("%s failed", task.get_name(), exc_info=error)
        self.tell(f"{task.get_name()} failed: {type(error).__name__}: {error}")

    def _turn(self) -> None:
        try:
            for job in [*self.jobs.values()]:
                if job.early <= (now := time.monotonic()):
                    job.called(now)
                    self.guard.do(job.name, job.call)
        finally:
            self._turned = time.monotonic()
            self._arm()

    def _arm(self) -> None:
        if self._loop is None or not self.jobs:
            return
        if self._timer is not None:
            self._timer.cancel()
        due = min(job.due for job in self.jobs.values())
        self._timer = self._loop.call_later(due - time.monotonic(), self._turn, context=self._context)
