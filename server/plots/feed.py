"""The binary half of the live socket: the newest row, and the bins that one viewer still lacks."""

from collections import OrderedDict, deque

import numpy as np

from server.plots.messages import Kind
from server.rig.history import Bins, History

CHUNK = 2048
"""Bins in one message at most, 33 s: the past comes in pieces, and what is urgent passes between them."""


KEPT = 8
"""Messages that are kept for others: within a frame most viewers lack the same bins of the same channels."""


class Plots:
    """PLOT messages of the newest bins, each made once for all who lack the same. Only the event loop uses it."""

    def __init__(self, history: History) -> None:
        self.history = history
        self._made: OrderedDict[tuple[int, int, tuple[int, ...]], tuple[int, bytes]] = OrderedDict()

    def newest(self, cursor: int, columns: list[int]) -> tuple[int, bytes]:
        """The bins from `cursor` on, `CHUNK` at most: the number of the next one, and the message."""
        stop = self.history.bin_stop
        lacks = cursor, stop, tuple(columns)
        if lacks not in self._made:
            bins = self.history.bins(cursor, stop, columns, CHUNK)
            self._made[lacks] = bins.stop, encode_plot(bins)
            if len(self._made) > KEPT:
                self._made.popitem(last=False)
        return self._made[lacks]


class Feed:
    """What one viewer plots, and what it has been sent of it."""

    def __init__(self, plots: Plots) -> None:
        self._plots, self._history = plots, plots.history
        self._columns: list[int] = []
        self._cursor = 0
        self._past: deque[tuple[list[int], int]] = deque()

    def choose(self, columns: list[int], since: float | None) -> None:
        """Follow these channels from now on; of those that are new the past comes too, the newest of it first.

        Of a viewer's first choice only the bins after `since` are its past.
        """
        fresh = [column for column in columns if column not in self._columns]
        if not self._columns:
            recent = max(0, self._history.bin_stop - CHUNK)
            self._cursor = recent if since is None else self._history.bin_at(since)
            self._past.clear()
        if fresh and (since is None or self._columns):
            self._past.append((fresh, self._cursor))
        self._columns = columns

    @property
    def behind(self) -> bool:
        """Whether there is more to send at once."""
        return bool(self._past) or self._lacks_new

    def next(self) -> bytes | None:
        """The next PLOT message; None while the viewer has everything."""
        if self._lacks_new:
            self._cursor, message = self._plots.newest(self._cursor, self._columns)
            return message
        while self._past:
            columns, stop = self._past.popleft()
            bins = self._history.bins(stop - CHUNK, stop, columns)
            if len(bins.t):
                self._past.appendleft((columns, bins.first))
                return encode_plot(bins)
        return None

    @property
    def _lacks_new(self) -> bool:
        return bool(self._columns) and self._cursor < self._history.bin_stop


def encode_plot(bins: Bins) -> bytes:
    """PLOT message, see `server.live.messages`."""
    head = np.array([Kind.PLOT, len(bins.t), len(bins.columns), bins.first], "<u4")
    parts = (head, bins.t, np.array(bins.columns, "<u4"), bins.low, bins.high)
    return b"".join(part.tobytes() for part in parts)
