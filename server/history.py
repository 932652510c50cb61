"""The last minute of telemetry for viewers: plot channels of every tick in a numpy ring, and the newest whole row."""

import threading
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from server.channels import CHANNELS, Rows, extract
from server.messages import Kind

BIN_TICKS = 16
"""Ticks in one bin of the history sent on connect: 16 ms at 1 kHz."""


@dataclass(frozen=True)
class Bins:
    """Extremes of `count` stretches of time: `t` (count,) [s, rig clock], `low` and `high` (count, channels)."""

    t: npt.NDArray[np.float64]
    low: npt.NDArray[np.float32]
    high: npt.NDArray[np.float32]


class History:
    """Ring of the newest `ticks` rows. Rows are numbered from 0 on; the link's thread adds, any thread reads."""

    def __init__(self, ticks: int = 60_000) -> None:
        self._lock = threading.Lock()
        self._t = np.zeros(ticks)
        self._values = np.zeros((ticks, len(CHANNELS)), np.float32)
        self._count = 0
        self._first = 0
        self._newest: Rows | None = None

    @property
    def count(self) -> int:
        """Rows added so far: the number of the next row."""
        return self._count

    @property
    def newest(self) -> Rows | None:
        """The newest telemetry row as an array of length 1; None before the first of this life of the rig."""
        return self._newest

    def add(self, rows: Rows) -> None:
        """Append telemetry rows, oldest first."""
        rows = rows[-len(self._t) :]
        values, newest = extract(rows), rows[-1:].copy()
        with self._lock:
            at = np.arange(self._count, self._count + len(rows)) % len(self._t)
            self._t[at] = rows["t_ns"] * 1e-9
            self._values[at] = values
            self._count += len(rows)
            self._newest = newest

    def forget(self) -> None:
        """Drop all rows (their numbers are not used again): the rig restarted, its clock may have too."""
        with self._lock:
            self._first = self._count
            self._newest = None

    def bins(self, start: int, stop: int, size: int) -> Bins:
        """Extremes of the rows [start, stop) in bins of `size` rows, the last perhaps shorter; nan is no extreme."""
        with self._lock:
            start = max(start, self._first, self._count - len(self._t))
            rows = np.arange(start, max(start, min(stop, self._count)))
            t, values = self._t[rows % len(self._t)], self._values[rows % len(self._t)]
        edges = np.arange(0, len(rows), size)
        if not len(edges):
            return Bins(t, values, values)
        middle = t[(edges + np.append(edges[1:], len(rows)) - 1) // 2]
        return Bins(middle, np.fmin.reduceat(values, edges), np.fmax.reduceat(values, edges))


def encode_frame(newest: Rows) -> bytes:
    """FRAME message: the newest telemetry row."""
    return _header(Kind.FRAME, 1) + newest.tobytes()


def encode_plot(bins: Bins) -> bytes:
    """PLOT message: times, then the lowest, then the highest values."""
    return _header(Kind.PLOT, len(bins.t)) + bins.t.tobytes() + bins.low.tobytes() + bins.high.tobytes()


def _header(kind: Kind, count: int) -> bytes:
    return np.array([kind, count], "<u4").tobytes()
