"""How long the threads of this process are held up: a busy machine's own doing, which no recorder can make up for."""

import os
import threading
import time
from collections import deque
from pathlib import Path

PERIOD_S = 10e-3
SPAN = 0.5
"""What a row is late comes from the last of this time: longer than one is on its way [s]."""
TASKS = Path("/proc/self/task")


class Lateness:
    """Watches from a thread of its own for how long all others, rerun's too, wait for a core or for the disk."""

    def __init__(self) -> None:
        self._held: dict[str, float] = {}
        """Of each thread since its start [s]."""
        self._totals = deque([(time.monotonic(), 0.0)])
        threading.Thread(target=self._run, daemon=True).start()

    @property
    def ticks(self) -> int:
        """For how long they were held up in the last SPAN, one after another [ms]; some 5 where nothing else runs."""
        return round(1e3 * (self._totals[-1][1] - self._totals[0][1]))

    def _run(self) -> None:
        before = time.monotonic()
        while True:
            time.sleep(PERIOD_S)
            now = time.monotonic()
            more = sum(self._more(thread, now - before) for thread in os.listdir(TASKS))
            self._totals.append((now, self._totals[-1][1] + more + max(0.0, now - before - 2.0 * PERIOD_S)))
            while now - self._totals[1][0] > SPAN:
                self._totals.popleft()
            before = now

    def _more(self, thread: str, since: float) -> float:
        """How long `thread` was ready without a core since the last look, or since then in the disk's hands [s]."""
        try:
            waited = int((TASKS / thread / "schedstat").read_text().split()[1]) * 1e-9
            state = (TASKS / thread / "stat").read_text().rpartition(")")[2].split()[0]
        except OSError:  # it has ended
            return 0.0
        more = waited - self._held.get(thread, waited)
        self._held[thread] = waited
        return more + (since if state == "D" else 0.0)
