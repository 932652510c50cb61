"""What is looked at at every beat, each look for itself: one that fails ends no other, and is tried again."""

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, TypeVar

log = logging.getLogger(__name__)

MEMORY = 60.0
"""A failure that does not come again for so long is forgotten, and news if it does [s]."""

T = TypeVar("T")


@dataclass
class Failure:
    """One kind of failure of one look."""

    text: str
    count: int
    last: float


class Watcher(Protocol):
    """Looks at something at every beat, and says what is new."""

    watched: str
    """What it looks at, in words."""

    def look(self) -> None:
        """Look once."""


class Looks:
    """Named calls. A failure is logged with its traceback once for every kind, and counted after that."""

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._failures: dict[tuple[str, type[BaseException]], Failure] = {}

    def do(self, name: str, look: Callable[[], T]) -> T | None:
        """What one gives; None where it failed."""
        try:
            return look()
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
            log.error("%s; it is tried again at every beat", text, exc_info=error)
        else:
            known.count, known.last = known.count + 1, now

    def _forget(self) -> None:
        now = self._now()
        for kind, failure in list(self._failures.items()):
            if now - failure.last > MEMORY:
                log.warning("%s: no more, after %d times", failure.text, failure.count)
                del self._failures[kind]
