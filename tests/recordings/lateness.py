"""How late the threads of this process are let run: a busy machine's own doing, which no recorder can make up for."""

import threading
import time

PERIOD = 5e-3
THREADS = 3
"""From the link's through the recorder's and rerun's own to the file: each may be as late [threads]."""


class Lateness:
    """Watches from a thread of its own."""

    def __init__(self) -> None:
        self._largest = 0.0
        threading.Thread(target=self._run, daemon=True).start()

    @property
    def ticks(self) -> int:
        """What a row may be late on its way for that reason [ms]; 1 to 10 on a machine with nothing else to do."""
        return round(1e3 * THREADS * self._largest)

    def _run(self) -> None:
        due = time.monotonic()
        while True:
            due = max(due + PERIOD, time.monotonic())
            time.sleep(max(0.0, due - time.monotonic()))
            self._largest = max(self._largest, time.monotonic() - due)
