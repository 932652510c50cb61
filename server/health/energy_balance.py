"""What the observer's energy gains beyond what its powers give it, over a window in which its ledger is of use.

Eq. HDOT holds for every step that is made; a slot without a tick is caught up in coarser steps, and an observer that is
set anew begins a new ledger. What such a moment leaves in the ledger stands there for good and says nothing of now.
"""

import math
from collections import deque

import numpy as np

from controller.arrays import Rows
from controller.schema.states import LATCHED

WINDOW_S, MARK_S = 10.0, 0.5
"""The span that is judged, and from one mark to the next, on the rig's clock [s]."""


class EnergyBalance:
    """The link's thread adds, any thread reads."""

    def __init__(self) -> None:
        self._marks: deque[tuple[float, float]] = deque()
        """Time on the rig's clock [s] and the ledger [J], since when nothing has broken it."""
        self._last: Rows | None = None
        self.gained = math.nan
        """Over the last WINDOW_S [J]; nan where fewer were seen without a break."""

    def add(self, rows: Rows) -> None:
        """Take telemetry rows, oldest first."""
        seen = rows if self._last is None else np.concatenate([self._last, rows])
        self._last = rows[-1:].copy()
        if broken(seen):
            self._marks.clear()
        t, ledger = 1e-9 * float(rows["t_ns"][-1]), float(rows["ledger"][-1])
        if not self._marks or t - self._marks[-1][0] >= MARK_S:
            self._marks.append((t, ledger))
        while t - self._marks[0][0] > WINDOW_S + MARK_S:
            self._marks.popleft()
        since, first = self._marks[0]
        self.gained = ledger - first if t - since >= WINDOW_S else math.nan


def broken(rows: Rows) -> bool:
    """Whether the ledger means something else at the end of these telemetry rows than at their beginning."""
    cleared = np.isin(rows["mode"][:-1], LATCHED) & ~np.isin(rows["mode"][1:], LATCHED)
    apart = np.diff(rows["slot"]) != 1
    return bool(cleared.any() or apart.any() or np.diff(rows["reseats"]).any())
