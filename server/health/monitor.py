"""Is this server itself sound? Its threads, the jobs of its event loop, and the loop; what is wrong is told once."""

from collections.abc import Callable, Sequence

from controller.system.scheduler import Scheduler
from controller.system.thread import SupervisedThread
from server.log.events import EventLog
from server.recorder.client import RecorderClient

HEALTH_S = 0.5
"""Between two checks."""


class HealthMonitor:
    """Nothing that it watches can end it, and it is a job of the scheduler itself."""

    def __init__(
        self, workers: Sequence[SupervisedThread | RecorderClient], scheduler: Scheduler, events: EventLog
    ) -> None:
        watchdog = scheduler.watchdog
        self._sources: dict[str, Callable[[], list[str]]] = {
            "threads": lambda: [worker.trouble for worker in workers if worker.trouble],
            "jobs": lambda: scheduler.guard.failing,
            "loop": lambda: [watchdog.trouble] if watchdog.trouble else [],
        }
        self._events = events
        self._told: set[str] = set()
        self.trouble = ""
        """All that was wrong at the last check."""

    def check(self) -> None:
        """Tell what is new."""
        found = {text: kind for kind in self._sources for text in self._sources[kind]()}
        told = {text if kind != "loop" else kind: text for text, kind in found.items()}
        for key, text in told.items():
            if key not in self._told:
                self._events.add(text, "error")
        self._told = set(told)
        self.trouble = "; ".join(found)

    def of(self, kind: str) -> str:
        """What is wrong with the "threads", the "jobs" or the "loop", "" where nothing is."""
        return "; ".join(self._sources[kind]())
