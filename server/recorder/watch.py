"""Says once in the log why a recording ended by itself: no one may be looking at the recorder's state."""

from server.log.events import EventLog
from server.recorder.client import RecorderClient

RECORDER_S = 0.1
"""Between two looks: a disk that hangs is found out by them."""


class RecorderWatch:
    """Looks at the recorder, and at its disk, now and then."""

    def __init__(self, recorder: RecorderClient, events: EventLog) -> None:
        self._recorder, self._events = recorder, events
        self._told = ""

    def look(self) -> None:
        """Look once."""
        problem = self._recorder.state().problem
        if problem and problem != self._told:
            self._events.add(problem, "error")
        self._told = problem
