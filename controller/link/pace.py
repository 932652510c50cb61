"""The pace of telemetry: what cannot follow from the last batch, by our own clock, is not taken."""

import numpy as np

from controller.errors import Unproven

SLACK = 2.0
"""By how much rows may be ahead of the time that passed here [s]: batches wait on the way, and clocks differ."""


class Pace:
    """The newest tick and time of the rig, and when they came by our clock. Pauses of either end are no jumps."""

    def __init__(self, dt: float, clock_ns: int, now: float) -> None:
        """The rig ticks every `dt` [s], and its own clock said `clock_ns` when ours said `now` [s]."""
        self._dt, self._now = dt, now
        self._clock_ns = clock_ns
        self._tick: int | None = None

    def judge(self, rows: np.ndarray, now: float) -> None:
        """Unproven names what jumped in `rows`, which came at `now` [s]; else they are what the next are judged by."""
        ticks, clock = rows["tick"], rows["t_ns"]
        if not len(rows):
            raise Unproven("refused: a batch holds no rows")
        if (ticks[1:] - ticks[:-1] != 1).any() or (clock[1:] < clock[:-1]).any():
            raise Unproven(f"refused: ticks or times of a batch are not in order, from tick {int(ticks[0])} on")
        tick, clock_ns, passed = int(ticks[-1]), int(clock[-1]), now - self._now
        if self._tick is not None:
            self._require("tick", (tick - self._tick) * self._dt, passed)
        self._require("t_ns", (clock_ns - self._clock_ns) * 1e-9, passed)
        self._tick, self._clock_ns, self._now = tick, clock_ns, now

    def _require(self, field: str, step: float, passed: float) -> None:
        if step > passed + SLACK:
            raise Unproven(f"refused: {field} went {step:.1f} s ahead in {passed:.1f} s, more than {SLACK:g} s too far")
