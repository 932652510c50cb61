"""The log: who did what, what was refused, what the rig did by itself. Kept for those who come later, told to all."""

import logging
from collections import deque
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Literal

from server.audit import tell
from server.event_file import EventFile
from server.messages import Event

Level = Literal["info", "warning", "error"]


log = logging.getLogger(__name__)


def to_log(event: Event) -> None:
    """A listener: the process's own log gets every line too."""
    log.log(logging.getLevelNamesMapping()[event.level.upper()], "%s", event.text)


class EventLog:
    """The last lines and their listeners. Only the event loop uses it. With a file the lines outlive the server."""

    def __init__(self, file: EventFile[Event] | None = None, kept: int = 500) -> None:
        self.recent: deque[Event] = deque(file.last() if file else [], maxlen=kept)
        self.listeners: list[Callable[[Event], None]] = []
        self._file = file

    def add(self, text: str, level: Level = "info") -> None:
        """Write a line and tell the listeners, and the audit of what it is part of."""
        plain = text.encode(errors="backslashreplace").decode()  # it may quote what is no Unicode, and no JSON
        event = Event(time=datetime.now(UTC), level=level, text=plain)
        self.recent.append(event)
        for listener in self.listeners:
            listener(event)
        tell(plain)
        self._keep(event)

    def refused(self, who: str, what: str, reason: str) -> None:
        """Write that `who` asked for `what` in vain."""
        self.add(f"{who}: {what} refused: {reason}", "warning")

    def _keep(self, event: Event) -> None:
        """Append to the file; the first failure is said, and ends it: a full disk must not end what goes on."""
        if self._file is None:
            return
        try:
            self._file.append(event)
        except OSError as error:
            self._file = None
            self.add(f"the log will not outlive this server: {error.strerror}", "warning")
