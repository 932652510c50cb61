"""What one end refused on its link: every one is counted, and the log hears of it once a minute at most."""

import logging
import threading
import time
from collections.abc import Callable

log = logging.getLogger(__name__)

QUIET_S = 60.0
"""Between two lines of the log [s]: a flood of refusals must not become a flood of lines."""


class Refusals:
    """Thread safe; `count` since the start."""

    def __init__(self, rig: str, now: Callable[[], float] = time.monotonic, what: str = "query") -> None:
        """`what` came on a key of `rig`."""
        self.count = 0
        self._rig, self._now, self._what = rig, now, what
        self._due = float("-inf")
        self._lock = threading.Lock()

    def note(self, key: str, error: Exception) -> bool:
        """One more message on `key` was refused; whether the log was told."""
        with self._lock:
            self.count += 1
            if self._now() < self._due:
                return False
            self._due = self._now() + QUIET_S
            fields = {"rig": self._rig, "expression": key, "refused": self.count}
            text = "rig %s, %s on %s: %s (%d refused since the start)"
            log.warning(text, self._rig, self._what, key, error, self.count, extra=fields)
            return True
