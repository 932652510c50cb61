"""Ten minutes of telemetry with a bound on memory: every row of the last minute, and extremes of 16 ticks before.

At 1 kHz a minute of rows is 57 MB and ten minutes of bins are 51 MB; both are arrays made once.
"""

import math
import mmap
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import numpy.typing as npt
from numpy.lib.recfunctions import repack_fields

from controller.arrays import Rows
from controller.errors import CommandRefused
from controller.schema.layout import copied, record_dtype
from controller.schema.messages import Telemetry
from server.http.given import given
from server.rig.channels import CHANNELS, column, extract
from server.rig.messages import PlotChannel
from server.rig.numbered import Numbered

BIN_TICKS = 16
"""Ticks in one bin: 16 ms at 1 kHz, just shorter than a frame of the live socket."""
ROWS = 60_000
BINS = 37_500
"""Ten minutes at 1 kHz."""


@dataclass(frozen=True)
class Bins:
    """Extremes in successive bins, the first of them number `first`; `columns` are places in `CHANNELS`.

    `t` (bins,) [s, rig clock] is the middle; `low` and `high` (bins, columns) are nan where no sample was a number.
    """

    first: int
    columns: list[int]
    t: npt.NDArray[np.float64]
    low: npt.NDArray[np.float32]
    high: npt.NDArray[np.float32]

    @property
    def stop(self) -> int:
        """Number of the bin after the last."""
        return self.first + len(self.t)


class History:
    """Rings of rows and bins. Both are numbered from 0 on; the link's thread adds, any thread reads."""

    def __init__(self, rows: int = ROWS, bins: int = BINS) -> None:
        self._lock = threading.Lock()
        self._rows = Numbered(rows, record_dtype(Telemetry))
        self._t = np.zeros(bins)
        self._low = np.zeros((bins, len(CHANNELS)), np.float32)
        self._high = np.zeros((bins, len(CHANNELS)), np.float32)
        self._first = self._binned = 0
        self._bin_first = self._bin_stop = 0
        self.newest: Rows | None = None
        """The newest telemetry row as an array of length 1; None before the first of this boot of the rig."""
        self._listeners: list[Callable[[Rows], None]] = []

    @property
    def count(self) -> int:
        """Rows added so far: the number of the next row."""
        return self._rows.count

    @property
    def bin_stop(self) -> int:
        """Number of the next bin."""
        return self._bin_stop

    @property
    def nbytes(self) -> int:
        """Memory of the rings when they are full [bytes]."""
        return self._rows.memory.nbytes + self._t.nbytes + self._low.nbytes + self._high.nbytes

    def claim(self) -> None:
        """Have all that memory now, not as it fills: what a server takes later is a leak. Holds up `add` by 0.3 s."""
        with self._lock:
            for ring in (self._rows.memory, self._t, self._low, self._high):
                ring.reshape(-1).view(np.uint8)[:: mmap.PAGESIZE] |= 0

    def listen(self, on_rows: Callable[[Rows], None]) -> None:
        """Give every row from now on to `on_rows` too, in the link's thread, once it is kept here."""
        self._listeners.append(on_rows)

    def add(self, rows: Rows) -> None:
        """Append telemetry rows, oldest first."""
        newest = copied(rows[-1:])
        with self._lock:
            self._rows.add(rows)
            self.newest = newest
            self._fill_bins()
        for on_rows in self._listeners:
            on_rows(rows)

    def largest(self, name: str, start: int) -> float:
        """Of one field in the rows from number `start` on, as far as they are kept; nan without any."""
        with self._lock:
            values = self._rows.column(name, max(start, self._oldest_row()), self._rows.count)
        return float(values.max()) if len(values) else math.nan

    def forget(self) -> None:
        """Drop everything (numbers are not used again): the rig restarted, its clock may have too."""
        with self._lock:
            self._first = self._binned = self._rows.count
            self._bin_first = self._bin_stop
            self.newest = None

    def bins(self, start: int, stop: int, columns: list[int], most: int = BINS) -> Bins:
        """The bins [start, stop) as far as they are kept, `most` of them from the oldest on."""
        with self._lock:
            start = max(start, self._oldest_bin())
            at = np.arange(start, max(start, min(stop, self._bin_stop, start + most))) % len(self._t)
            cells = at[:, None], np.array(columns, np.int64)
            return Bins(start, columns, self._t[at], self._low[cells], self._high[cells])

    def bin_at(self, t: float) -> int:
        """Number of the first bin at or after time t [s]; `bin_stop` if there is none."""
        with self._lock:
            oldest = self._oldest_bin()
            times = self._t[np.arange(oldest, self._bin_stop) % len(self._t)]
            return oldest + int(np.searchsorted(times, t))

    def samples(self, start: float, stop: float, channels: list[PlotChannel]) -> npt.NDArray[np.float64] | None:
        """Time [s] and the channels of every row in [start, stop] s, (n, 1 + channels); None if older ones are gone."""
        rows = self.rows(start, stop)
        if rows is None:
            return None
        return np.column_stack([rows["t_ns"] * 1e-9, *(column(rows, channel) for channel in channels)])

    def rows(self, start: float, stop: float) -> Rows | None:
        """A copy of every row in [start, stop] s on the rig's clock; None if older ones are gone."""
        with self._lock:
            oldest = self._oldest_row()
            t_ns = self._rows.column("t_ns", oldest, self._rows.count)
            if oldest > self._first and start < t_ns[0] * 1e-9:
                return None
            begin, end = np.searchsorted(t_ns, (start * 1e9, stop * 1e9))
            return self._rows.between(oldest + int(begin), oldest + int(end))

    def _oldest_row(self) -> int:
        return max(self._first, self._rows.oldest)

    def _oldest_bin(self) -> int:
        return max(self._bin_first, self._bin_stop - len(self._t))

    def _fill_bins(self) -> None:
        """Bin the rows that fill a bin; what is left waits for the next rows."""
        self._binned = max(self._binned, self._oldest_row())
        whole = (self._rows.count - self._binned) // BIN_TICKS
        if not whole:
            return
        rows = self._rows.between(self._binned, self._binned + whole * BIN_TICKS)
        values = extract(rows).reshape(whole, BIN_TICKS, -1)
        at = np.arange(self._bin_stop, self._bin_stop + whole) % len(self._t)
        self._t[at] = rows["t_ns"][BIN_TICKS // 2 :: BIN_TICKS] * 1e-9
        self._low[at] = np.fmin.reduce(values, axis=1)
        self._high[at] = np.fmax.reduce(values, axis=1)
        self._binned += whole * BIN_TICKS
        self._bin_stop += whole


class Largest:
    """The largest of one field in the rows since it was last asked for; nan where none came."""

    def __init__(self, history: History, name: str) -> None:
        self._history, self._name, self._read = history, name, 0

    def take(self) -> float:
        """It."""
        start, self._read = self._read, self._history.count
        return self._history.largest(self._name, start)


class Gathered:
    """Some fields of every row since `begin` on the rig's clock [s], taken piece by piece: a minute at most is kept."""

    def __init__(self, history: History, begin: float, names: Sequence[str]) -> None:
        self._history, self._end, self._names = history, begin, list(names)
        self._parts: list[Rows] = []

    def take(self, end: float) -> None:
        """What has come up to `end` [s]; raises CommandRefused where some of it is gone already."""
        if end <= self._end:
            return
        rows = self._history.rows(self._end, end)
        if rows is None or not len(rows):
            raise CommandRefused("telemetry of this step was lost")
        self._parts.append(repack_fields(rows[self._names]))
        self._end = end

    def rows(self) -> Rows:
        """All that was taken (n,), with these fields only."""
        if not self._parts:
            raise CommandRefused("telemetry of this step was lost")
        found: Rows = np.concatenate(self._parts)
        return found


GivenHistory = Annotated[History, given(History)]
