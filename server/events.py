"""The log: who did what, what was refused, what the rig did by itself. Kept for those who come later, told to all."""

from collections import deque
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Literal

from server.messages import Event

Level = Literal["info", "warning", "error"]


class EventLog:
    """The last lines and their listeners. Only the event loop uses it."""

    def __init__(self, kept: int = 500) -> None:
        self.recent: deque[Event] = deque(maxlen=kept)
        self.listeners: list[Callable[[Event], None]] = []

    def add(self, text: str, level: Level = "info") -> None:
        """Write a line and tell the listeners."""
        event = Event(time=datetime.now(UTC), level=level, text=text)
        self.recent.append(event)
        for listener in self.listeners:
            listener(event)

    def refused(self, who: str, what: str, reason: str) -> None:
        """Write that `who` asked for `what` in vain."""
        self.add(f"{who}: {what} refused: {reason}", "warning")
