"""A time window of chosen signals of a recording, in memory: what every format is written from."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from controller.errors import ParameterError, RecordingError
from recordings.exporting.signals import TIP, Signal, chosen
from recordings.importing.tip import IMPORT_RIG
from recordings.reader import read_about, read_rows

Array = np.ndarray[Any, Any]


@dataclass(frozen=True)
class Choice:
    """What is asked for: names of signals or of fields (all without any) and times [s] since the first row."""

    signals: tuple[str, ...] = ()
    start: float | None = None
    stop: float | None = None


@dataclass(frozen=True)
class Column:
    """The values (k,) of one signal at the rows `at` (k,) of its table, rising; None: at all rows."""

    signal: Signal
    values: Array
    at: Array | None

    def part(self, first: int, end: int) -> tuple[Array, Array | None]:
        """Values at the rows from `first` up to `end`, and those rows counted from `first`."""
        if self.at is None:
            return self.values[first:end], None
        low, high = np.searchsorted(self.at, [first, end])
        return self.values[low:high], self.at[low:high] - first


@dataclass(frozen=True)
class Table:
    """Columns over the times `t_ns` (n,) since the recording's first row [ns, int64], which was at `wall_ns` [Unix]."""

    t_ns: Array
    wall_ns: int
    columns: Sequence[Column]

    @cached_property
    def t(self) -> Array:
        """Times since the recording's first row (n,) [s]."""
        return np.asarray(self.t_ns / 1e9)


class Rows:
    """All rows of one recording; RecordingError when `path` cannot be read or holds none."""

    def __init__(self, path: Path) -> None:
        self._rows = read_rows(path)
        about, _ = read_about(path)
        clock = self._rows["t_ns"]
        if not len(clock):
            raise RecordingError(f"{path.name} holds no rows")
        self._fields = TIP if about.rig == IMPORT_RIG else tuple(filter(self._is_known, self._rows))
        self.t_ns = clock - clock[0]
        self.wall_ns = int(clock[0]) + about.wall_offset_ns

    def table(self, choice: Choice) -> Table:
        """What is asked for; ParameterError for an unknown signal or a window without rows."""
        window = self._window(choice)
        columns = [self._column(signal, window) for signal in chosen(choice.signals, self._fields)]
        return Table(self.t_ns[window], self.wall_ns, columns)

    def _is_known(self, name: str) -> bool:
        """Whether any value of this field was recorded: a rig without a twin has no backbone of one."""
        values = self._rows[name]
        return len(values) > 0 and not (values.dtype.kind == "f" and np.isnan(values).all())

    def _window(self, choice: Choice) -> slice:
        length = self.t_ns[-1] / 1e9
        start, stop = (choice.start or 0.0), (length if choice.stop is None else choice.stop)
        if not 0.0 <= start <= length:
            raise ParameterError(f"from = {start:g} s is outside the recording's [0, {length:.3f}] s")
        if not start <= stop:
            raise ParameterError(f"to = {stop:g} s is before from = {start:g} s")
        seconds = self.t_ns / 1e9
        window = slice(int(np.searchsorted(seconds, start)), int(np.searchsorted(seconds, stop, side="right")))
        if window.start == window.stop:
            raise ParameterError(f"from = {start:g} s to {stop:g} s: the recording has no row there")
        return window

    def _column(self, signal: Signal, window: slice) -> Column:
        place: Any = (slice(None), *signal.index)
        values = self._rows[signal.field][place]
        if f"{signal.field}_tick" not in self._rows:
            return Column(signal, values[window], None)
        at, there = _places(self._rows["tick"], self._rows[f"{signal.field}_tick"])
        inside = there & (at >= window.start) & (at < window.stop)
        return Column(signal, values[inside], at[inside] - window.start)


def _places(tick: Array, slow: Array) -> tuple[Array, Array]:
    """Rows (k,) at the ticks `slow` (k,), and which of them are there: a killed writer may have lost some rows."""
    rows, wanted = _unique(tick), _unique(slow)
    at = np.minimum(np.searchsorted(rows, wanted), len(rows) - 1)
    return at, rows[at] == wanted


def _unique(tick: Array) -> Array:
    """Ticks that rise for ever: those of a rig that was restarted begin again."""
    life = np.cumsum(np.diff(tick, prepend=tick[:1]) < 0)
    return np.asarray((life << 44) + tick)
