"""Telemetry rows in order and without gaps, whatever batches get lost on the way."""

from collections.abc import Callable

import numpy as np

from controller.link.keys import REPLAY_MAX

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
