"""Threads: one that is supervised, with the life cycle of all, and one that does a single thing which may hang."""

import logging
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import TypeVar

from controller.system.lifecycle import retry_delay

log = logging.getLogger(__name__)

T = TypeVar("T")

FAILURE_KEPT_S = 60.0
"""For so long a failure is trouble after the thread has begun again; failures within it count as in a row."""
HANG_S = 10.0


class SupervisedThread:
    """Runs `work` in a daemon thread called `name` until `work` returns, which is its orderly end.

    What else ends it is logged, and it begins again. `work` calls `turn` at least every `hang_s` seconds, and `rest`
    before it waits for as long as it takes; or `wait`, which does both.
    """

    def __init__(self, name: str, work: Callable[[], None], hang_s: float = HANG_S) -> None:
        self.name, self._work, self._hang_s = name, work, hang_s
        self._turned: float | None = None
        self._failures, self._failed = 0, -FAILURE_KEPT_S
        self._why = ""
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def stop(self, timeout: float | None = None) -> bool:
        """Tell `work`, wait for its end, and begin it again no more; whether it has ended."""
        self._stopping.set()
        if self._thread is not threading.current_thread() and self.started:
            self._thread.join(timeout)
        return not self.alive

    def turn(self) -> None:
        """Called by `work`: it goes on."""
        self._turned = time.monotonic()

    def rest(self) -> None:
        """Called by `work`: it waits, and that is in order."""
        self._turned = None

    def wait(self, seconds: float) -> bool:
        """Called by `work`: wait so long, or until it is to end; whether it is."""
        self.rest()
        over = self._stopping.wait(seconds)
        self.turn()
        return over

    @property
    def started(self) -> bool:
        """Whether it ever began."""
        return self._thread.ident is not None

    @property
    def stopping(self) -> bool:
        """Whether it was told to end."""
        return self._stopping.is_set()

    @property
    def alive(self) -> bool:
        """Whether the thread is there."""
        return self._thread.is_alive()

    @property
    def stuck(self) -> float:
        """For how long it has not turned [s]; 0 while it waits."""
        turned = self._turned
        return 0.0 if turned is None else time.monotonic() - turned

    @property
    def trouble(self) -> str:
        """What is wrong with it, "" when it is well."""
        if not self.alive and not self.stopping:
            return f"the thread {self.name} has ended"
        if self.stuck > self._hang_s:
            return f"the thread {self.name} hangs"
        if time.monotonic() - self._failed < FAILURE_KEPT_S:
            return f"the thread {self.name} was ended by {self._why}, and began again"
        return ""

    def _run(self) -> None:
        while True:
            try:
                self.turn()
                return self._work()
            except BaseException as error:  # SystemExit too: it would be heard of nowhere else
                self._note(error)
            finally:
                self.rest()
            if self._stopping.wait(retry_delay(self._failures)):
                return

    def _note(self, error: BaseException) -> None:
        now = time.monotonic()
        self._failures = self._failures + 1 if now - self._failed < FAILURE_KEPT_S else 1
        self._failed, self._why = now, f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
        log.error("thread %s ended, and begins again", self.name, exc_info=error)


def in_thread(name: str, work: Callable[[], T]) -> "Future[T]":
    """What comes of `work`, or what it raises; it runs in a daemon thread, so that nothing has to wait for its end."""
    found: Future[T] = Future()

    def run() -> None:
        try:
            found.set_result(work())
        except BaseException as error:  # for the one who asks
            found.set_exception(error)

    threading.Thread(target=run, name=name, daemon=True).start()
    return found
