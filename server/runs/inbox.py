"""From the link's thread to the event loop: the telemetry rows of a run, at most 30 s of them."""

import threading

from controller.arrays import Rows

ROWS = 30_000
"""Rows that wait at most, some 28 MB: 30 s at 1 kHz, as long as the rig's own ring holds them. A frame takes 17."""


class Inbox:
    """Keeps batches of rows while it is open. A full one closes itself: its run is then judged by holes, so it ends."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._batches: list[Rows] = []
        self._open = self._lost = False
        self._rows = 0

    def __len__(self) -> int:
        """Rows that wait."""
        return self._rows

    @property
    def is_open(self) -> bool:
        """Whether rows are kept."""
        return self._open

    @property
    def lost(self) -> bool:
        """Whether it was full since it was opened."""
        return self._lost

    def open(self) -> None:
        """Keep what comes from now on, and nothing older."""
        self._restart(is_open=True)

    def close(self) -> None:
        """Keep nothing."""
        self._restart(is_open=False)

    def put(self, rows: Rows) -> None:
        """Take a batch (n,)."""
        with self._lock:
            if not self._open:
                return
            self._rows += len(rows)
            self._batches.append(rows)
            if self._rows > ROWS:
                self._batches, self._rows = [], 0
                self._open, self._lost = False, True

    def batches(self) -> list[Rows]:
        """What came since the last look, oldest first."""
        with self._lock:
            found, self._batches, self._rows = self._batches, [], 0
        return found

    def _restart(self, is_open: bool) -> None:
        with self._lock:
            self._batches, self._rows = [], 0
            self._open, self._lost = is_open, False
