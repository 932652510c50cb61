"""A thread that somebody watches: what ends it is logged, and it begins anew; what hangs in it is seen from outside."""

import logging
import threading
import time
from collections.abc import Callable

from controller.system.child import retry_delay

log = logging.getLogger(__name__)

MEMORY = 60.0
"""Seconds for which a failure is trouble, after the thread has begun anew; failures within it count as in a row."""


class Worker:
    """Runs `work` in a daemon thread called `name` until `work` returns, which is its orderly end.

    `work` calls `turn` at least every `most` seconds, and `rest` before it waits for as long as it takes.
    """

    def __init__(self, name: str, work: Callable[[], None], most: float = 10.0) -> None:
        self.name, self._work, self._most = name, work, most
        self._turned: float | None = None
        self._failures, self._failed = 0, -MEMORY
        self._why = ""
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def turn(self) -> None:
        """Called by `work`: it goes on."""
        self._turned = time.monotonic()

    def rest(self) -> None:
        """Called by `work`: it waits, and nobody has to worry."""
        self._turned = None

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
        """What is wrong with it, "" if nothing is."""
        if not self.alive and not self._closing.is_set():
            return f"the thread {self.name} has ended"
        if self.stuck > self._most:
            return f"the thread {self.name} hangs"
        if time.monotonic() - self._failed < MEMORY:
            return f"the thread {self.name} was ended by {self._why}, and began anew"
        return ""

    def join(self, timeout: float | None = None) -> bool:
        """Wait for its end, and begin it anew no more; whether it came."""
        self._closing.set()
        if self._thread is not threading.current_thread() and self._thread.ident is not None:
            self._thread.join(timeout)
        return not self._thread.is_alive()

    def _run(self) -> None:
        while True:
            try:
                self.turn()
                return self._work()
            except BaseException as error:  # whatever it is, SystemExit too: nobody else would hear of it
                self._note(error)
            finally:
                self.rest()
            if self._closing.wait(retry_delay(self._failures)):
                return

    def _note(self, error: BaseException) -> None:
        now = time.monotonic()
        self._failures = self._failures + 1 if now - self._failed < MEMORY else 1
        self._failed, self._why = now, f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
        log.error("thread %s ended, and begins anew", self.name, exc_info=error)
