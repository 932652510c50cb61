"""How well a run goes, from every tick of it, in bounded memory however long it lasts."""

from collections import deque

import numpy as np

from controller.arrays import Array, Rows
from controller.simulation.metrics import phase_lags
from recordings.read.metrics import ErrorSums
from server.runs.messages import Figures

PHASE_ROWS = 100_000
"""So many of the last ticks give the phase lag."""


class Tally:
    """Sums over the ticks that are judged. The tip is the measured one; a tick without its marker has no error."""

    def __init__(self, frequency: tuple[float, float] | None) -> None:
        self._frequency = frequency
        self._ticks = self._slots = self._saturated = 0
        self._errors = ErrorSums()
        self._slot: int | None = None
        self._kept = 0
        self._wanted: deque[Array] = deque()
        self._actual: deque[Array] = deque()

    @property
    def rmse(self) -> float | None:
        """Root of the mean squared distance so far [m]."""
        return self._errors.rmse

    def add(self, rows: Rows) -> None:
        """Count telemetry rows (n,); they follow the last ones."""
        if not len(rows):
            return
        last = int(rows["slot"][-1])
        self._slots += last - (int(rows["slot"][0]) - 1 if self._slot is None else self._slot)
        self._slot = last
        self._ticks += len(rows)
        self._saturated += int(np.count_nonzero(rows["saturated"]))
        self._errors.add(rows["p_ref"], rows["p_meas"])
        if self._frequency is not None:
            self._keep(rows["p_ref"].copy(), rows["p_meas"].copy())

    def pause(self) -> None:
        """What comes next does not follow at once: the slots between are not lost."""
        self._slot = None

    def figures(self) -> Figures:
        """All of them, as `controller.simulation.metrics` defines them."""
        lag = self._lags()
        return Figures(
            rmse=self.rmse,
            max_error=self._errors.largest,
            lag_deg_x=lag.get("lag_deg_x"),
            lag_deg_y=lag.get("lag_deg_y"),
            saturated_share=self._saturated / self._ticks if self._ticks else None,
            on_time_share=self._ticks / self._slots if self._slots else None,
        )

    def _keep(self, p_ref: Array, p: Array) -> None:
        self._wanted.append(p_ref)
        self._actual.append(p)
        self._kept += len(p)
        while self._kept - len(self._wanted[0]) >= PHASE_ROWS:
            self._kept -= len(self._wanted.popleft())
            self._actual.popleft()

    def _lags(self) -> dict[str, float]:
        """Phase lags [deg] where there are any."""
        if not self._wanted or self._frequency is None:
            return {}
        return phase_lags(np.vstack(self._wanted), np.vstack(self._actual), self._frequency)
