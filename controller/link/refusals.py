"""What the rig refused on its link: every one is counted, and the log hears of it once a minute at most."""

import logging
import threading
import time
from collections.abc import Callable

log = logging.getLogger(__name__)

PAUSE = 60.0
"""Between two lines of the log [s]: a flood of refusals must not become a flood of lines."""


class Refusals:
    """Thread safe; `count` since the start."""

    def __init__(self, rig: str, now: Callable[[], float] = time.monotonic) -> None:
        self.count = 0
        self._rig, self._now = rig, now
        self._due = float("-inf")
        self._lock = threading.Lock()

    def note(self, key: str, error: Exception) -> bool:
        """One more query on `key` was refused; whether the log was told."""
        with self._lock:
            self.count += 1
            if self._now() < self._due:
                return False
            self._due = self._now() + PAUSE
            fields = {"rig": self._rig, "expression": key, "refused": self.count}
            log.warning(
                "rig %s, query on %s: %s (%d refused since the start)", self._rig, key, error, self.count, extra=fields
            )
            return True
