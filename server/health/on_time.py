"""How much of the last minute the loop was on time, from the rig's own count of slots and of those it lost."""

import math
from collections import deque

from controller.arrays import Rows

WINDOW_S, MARK_S = 60.0, 1.0
"""The span that is judged, and from one mark to the next, on the rig's clock [s]."""
LEAST_S = 5.0
"""Before as much was seen there is no figure: one slow start would be all of it."""


class OnTime:
    """The link's thread adds, any thread reads; what was lost before the first row was seen does not count."""

    def __init__(self) -> None:
        self._marks: deque[tuple[float, int, int]] = deque()
        """Time on the rig's clock [s], slot, and slots lost so far."""
        self._found = (math.nan, math.nan)

    def add(self, rows: Rows) -> None:
        """Take telemetry rows, oldest first; a rig that was started again begins again."""
        t, slot, lost = 1e-9 * float(rows["t_ns"][-1]), int(rows["slot"][-1]), int(rows["lost"][-1])
        if self._marks and (slot < self._marks[-1][1] or lost < self._marks[-1][2]):
            self._marks.clear()
        if not self._marks or t - self._marks[-1][0] >= MARK_S:
            self._marks.append((t, slot, lost))
        while t - self._marks[0][0] > WINDOW_S + MARK_S:
            self._marks.popleft()
        since, first, gone = self._marks[0]
        slots, gone = slot - first, lost - gone
        known = t - since >= LEAST_S and slots > 0
        self._found = (min(1.0, max(0.0, 1.0 - gone / slots)), float(gone)) if known else (math.nan, math.nan)

    @property
    def share(self) -> float:
        """Share of the slots in which the loop ticked, in [0, 1]; nan before LEAST_S."""
        return self._found[0]

    @property
    def lost(self) -> float:
        """Slots without a tick in the same time; nan before LEAST_S."""
        return self._found[1]
