"""What a run saw of the tip, for its path to be learned from."""

from typing import NamedTuple

import numpy as np

from controller.arrays import Array, Rows
from server.runs.lap import Leg
from server.runs.messages import Learned

P_MEAS, AGE = slice(0, 2), 2
"""Columns of what is kept."""


class Seen:
    """The tip at every row of the first lap, and of the last one after it; in bounded memory however many there are."""

    def __init__(self, leg: Leg) -> None:
        """Of a run from its beginning."""
        self._again, n = leg.again, len(leg.p) - leg.again
        self.first: Array = np.full((n, 3), np.nan, np.float32)
        """(n,3) [m, m, s]: measured tip and how old it was, nan where no row told."""
        self.later: Array | None = np.full((n, 3), np.nan, np.float32) if leg.ticks > len(leg.p) else None
        """The same of a row's last lap; None where there is one lap only."""

    def add(self, index: Array, rows: Rows) -> None:
        """Telemetry rows (k,) at the ticks `index` (k,) of the leg."""
        found = np.column_stack([rows["p_meas"], rows["measurement_age"]])
        lap, place = np.divmod(index - self._again, len(self.first))
        self.first[place[lap == 0]] = found[lap == 0]
        if self.later is not None:
            self.later[place[lap > 0]] = found[lap > 0]


class Repeat(NamedTuple):
    """A run from which its path is learned."""

    before: Learned
    """As it began."""
    seen: Seen | None
    """None: it was broken off."""
    rmse: float | None
    """[m]"""
