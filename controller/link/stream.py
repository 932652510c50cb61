"""Telemetry rows in order and without gaps, whatever batches get lost on the way, and no faster than time passes."""

from collections.abc import Callable

import numpy as np

from controller.errors import Unproven
from controller.link.keys import REPLAY_MAX

SLACK_S = 2.0
"""By how much rows may be ahead of the time that passed here: batches wait on the way, and clocks differ."""

DRIFT = 1e-3
"""Most by which two clocks drift apart in a time, as a share of it: ten times that of a bad crystal."""

Replay = Callable[[int, int], np.ndarray]
Deliver = Callable[[np.ndarray], None]


class RowStream:
    """Takes batches of Telemetry rows as they come and delivers every tick once, in order.

    A gap is refilled by `replay(first, count)`; what the ring has lost already is skipped and counted in `gaps`.
    """

    def __init__(self, replay: Replay, deliver: Deliver) -> None:
        self._replay = replay
        self._deliver = deliver
        self._next: int | None = None
        self.gaps = 0

    def expect(self, tick: int | None) -> None:
        """The next row is `tick`, or, when None, whatever comes first."""
        self._next = tick

    def take(self, rows: np.ndarray) -> None:
        """One batch: consecutive rows, possibly behind a gap, possibly seen already."""
        first = int(rows["tick"][0])
        if self._next is None:
            self._next = first
        while self._next < first:
            self._refill(self._next, first)
        self._pass_on(rows)

    def _refill(self, start: int, end: int) -> None:
        """Fetch a first part of [start, end), or give it up."""
        rows = self._replay(start, min(end - start, REPLAY_MAX))
        rows = rows[rows["tick"] < end]
        found = int(rows["tick"][0]) if len(rows) else end
        self.gaps += found - start
        self._next = found
        self._pass_on(rows)

    def _pass_on(self, rows: np.ndarray) -> None:
        """Deliver those of `rows`, whose ticks rise, that are new."""
        ticks = rows["tick"]
        fresh = rows[int(np.searchsorted(ticks, self._next or 0)) :]
        if len(fresh):
            self._next = int(ticks[-1]) + 1
            self._deliver(fresh)


class Pace:
    """Judges what cannot follow from the last batch. Pauses of either end, and what they make late, are no jumps.

    The rig's clock is judged by ours, its ticks by its own clock. A batch is never heard before it was made, so the one
    that was heard soonest tells best how far the rig's clock is ahead; what is heard late tells nothing.
    """

    def __init__(self, dt: float, clock_ns: int, asked: float) -> None:
        """The rig ticks every `dt` [s]; asked when our clock said `asked` [s], its own said `clock_ns` afterwards."""
        self._dt, self._now = dt, asked
        self._clock_s = 1e-9 * clock_ns
        self._ahead_s = self._clock_s - asked
        """Of the rig's clock before ours, as most that it can be."""
        self._tick: int | None = None

    def judge(self, rows: np.ndarray, now: float) -> None:
        """Unproven names what jumped in `rows`, which came at `now` [s]; else they are what the next are judged by."""
        ticks, clock = rows["tick"], rows["t_ns"]
        if not len(rows):
            raise Unproven("refused: a batch holds no rows")
        if (ticks[1:] - ticks[:-1] != 1).any() or (clock[1:] < clock[:-1]).any():
            raise Unproven(f"refused: ticks or times of a batch are not in order, from tick {int(ticks[0])} on")
        tick, clock_s, passed = int(ticks[-1]), 1e-9 * int(clock[-1]), now - self._now
        ahead_s, step_s = clock_s - now, clock_s - self._clock_s
        if self._tick is not None:
            _require("tick", (tick - self._tick) * self._dt, step_s)
        _require("t_ns", step_s, step_s + self._ahead_s - ahead_s)
        self._ahead_s = max(ahead_s, self._ahead_s - DRIFT * max(0.0, passed))
        self._tick, self._clock_s, self._now = tick, clock_s, now


def _require(field: str, step: float, passed: float) -> None:
    if step > passed + SLACK_S:
        raise Unproven(f"refused: {field} went {step:.1f} s ahead in {passed:.1f} s, more than {SLACK_S:g} s too far")
