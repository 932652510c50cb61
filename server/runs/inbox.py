"""From the link's thread to the event loop: the telemetry rows of a run."""

from collections import deque
from collections.abc import Iterator

from server.channels import Rows


class Inbox:
    """Keeps batches of rows while it is open."""

    def __init__(self) -> None:
        self._open = False
        self._batches: deque[Rows] = deque()

    def open(self) -> None:
        """Keep what comes from now on, and nothing older."""
        self._batches.clear()
        self._open = True

    def close(self) -> None:
        """Keep nothing."""
        self._open = False
        self._batches.clear()

    def put(self, rows: Rows) -> None:
        """Take a batch (n,)."""
        if self._open:
            self._batches.append(rows)

    def batches(self) -> Iterator[Rows]:
        """What came since the last look, oldest first."""
        while self._batches:
            yield self._batches.popleft()
