"""Is this server itself sound? Its threads, its looks at every beat, and its event loop; what is wrong is told once."""

import time
from collections.abc import Callable, Sequence

from controller.system.looks import Looks
from controller.system.worker import Worker
from server.health.loop_watchdog import LoopWatchdog
from server.log.events import EventLog

PERIOD = 0.5
"""Seconds from one look to the next."""


class Soundness:
    """Nothing that it watches can end it, and it is one of the looks itself."""

    watched = "the server's own soundness"

    def __init__(self, workers: Sequence[Worker], looks: Looks, loop: LoopWatchdog, events: EventLog) -> None:
        self._sources: dict[str, Callable[[], list[str]]] = {
            "threads": lambda: [worker.trouble for worker in workers if worker.trouble],
            "looks": lambda: looks.failing,
            "loop": lambda: [loop.trouble] if loop.trouble else [],
        }
        self._events = events
        self._told: set[str] = set()
        self._due = 0.0
        self.trouble = ""
        """All that was wrong at the last look."""

    def look(self) -> None:
        """Called at every beat: look where that is due, and tell what is new."""
        if (now := time.monotonic()) < self._due:
            return
        self._due = now + PERIOD
        found = {text: kind for kind in self._sources for text in self._sources[kind]()}
        told = {text if kind != "loop" else kind: text for text, kind in found.items()}
        for key, text in told.items():
            if key not in self._told:
                self._events.add(text, "error")
        self._told = set(told)
        self.trouble = "; ".join(found)

    def of(self, kind: str) -> str:
        """What is wrong with the "threads", the "looks" or the "loop", "" where nothing is."""
        return "; ".join(self._sources[kind]())
