"""How well a run goes, from every tick of it, in bounded memory however long it lasts."""

import math
from collections import deque

import numpy as np

from controller.arrays import Array, Rows
from controller.simulation.metrics import phase_lags
from recordings.read.metrics import ErrorSums
from server.runs.messages import Figures

PHASE_ROWS = 100_000
"""So many of the last ticks give the phase lag."""


COURSE = 128
"""Parts of a run at most, of each of which the largest error is kept."""


class ErrorCourse:
    """The largest error in each of 64 to 127 equal parts of a run: where all are full, two become one."""

    def __init__(self) -> None:
        self._parts: Array = np.empty(0)
        self._rest: Array = np.empty(0)
        self._width = 1

    def add(self, error: Array) -> None:
        """Take the errors (n,) [m] of the next ticks, nan where there was none."""
        self._rest = np.concatenate((self._rest, error))
        while len(self._rest) >= self._width:
            count = min(len(self._rest) // self._width, COURSE - len(self._parts))
            whole, self._rest = np.split(self._rest, [count * self._width])
            self._parts = np.concatenate((self._parts, np.fmax.reduce(whole.reshape(count, -1), axis=1)))
            if len(self._parts) == COURSE:
                self._parts = np.fmax.reduce(self._parts.reshape(-1, 2), axis=1)
                self._width *= 2

    def parts(self) -> list[float | None]:
        """Largest error [m] of each, the last perhaps shorter; None where no tick saw the tip."""
        last = np.fmax.reduce(self._rest, keepdims=True) if len(self._rest) else self._rest
        return [round(value, 7) if math.isfinite(value) else None for value in (*self._parts.tolist(), *last.tolist())]


class Tally:
    """Sums over the ticks that are judged. The tip is the measured one; a tick without its marker has no error."""

    def __init__(self, frequency: tuple[float, float] | None, dt: float) -> None:
        """`frequency` [Hz] at which x and y are to swing, `dt` [s] from tick to tick."""
        self._frequency, self._dt = frequency, dt
        self._ticks = self._slots = self._saturated = 0
        self._errors, self.course = ErrorSums(), ErrorCourse()
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
        self.course.add(np.linalg.norm(rows["p_ref"] - rows["p_meas"], axis=1))
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
        return phase_lags(np.vstack(self._wanted), np.vstack(self._actual), self._frequency, self._dt)
