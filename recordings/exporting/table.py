"""A time window of chosen signals of a recording, piece by piece: what every format is written from."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from controller.arrays import Rows, Values
from controller.errors import ParameterError, RecordingError
from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.system.progress import ProgressCallback, no_progress
from recordings.exporting.feed import Survey, feed, surveyed
from recordings.exporting.signals import SIGNALS, TIP, Signal, chosen
from recordings.format import sidecar
from recordings.format.chunks import Chunks, Part, opened
from recordings.format.messages import Bookmark, Profile
from recordings.format.profiles import SLOW_FIELDS, TICKS
from recordings.format.signals import BACKBONES, GROUPS
from recordings.importing.tip import IMPORT_RIG
from recordings.read.reader import DENSE, SCALARS, SLOW, about_of, clock_origin, read_bookmarks

CLOCKS = ("tick", "t_ns")
"""Fields that are timelines of every entity."""


@dataclass(frozen=True)
class Place:
    """`column` of `entity`; `sign` -1 where it is written negated, `dense` where it is written at every tick."""

    entity: str
    column: int
    sign: int
    dense: bool


class Layout:
    """Which entities a profile writes, and what is where in them."""

    def __init__(self, profile: Profile) -> None:
        slow, dense = (SLOW_FIELDS, (TICKS,)) if profile == "standard" else (frozenset[str](), GROUPS)
        self.clock = dense[-1].path
        """The entity that is written last at every tick: what has its row there has it everywhere."""
        slower = {path: component for path, (_, component) in SLOW.items()}
        self._components = slower | DENSE | {TICKS.path: SCALARS}
        groups = [(group, True) for group in dense] + [(group, False) for group in GROUPS if slow]
        self._series = {
            (series.field, series.index): Place(group.path, column, 1, is_dense)
            for group, is_dense in groups
            for column, series in enumerate(group.series)
            if is_dense != (series.field in slow)
        }
        self._entities = {field: path for path, (field, _) in SLOW.items()}

    def components_of(self, signals: Iterable[Signal]) -> dict[str, str]:
        """The entities that hold `signals` and the clock, each with the component that has its numbers."""
        return {
            entity: self._components[entity] for entity in {self.clock} | {self.place(one).entity for one in signals}
        }

    def dense(self, signals: Iterable[Signal]) -> set[str]:
        """Those of these entities that are written at every tick."""
        places = [self.place(signal) for signal in signals]
        return {self.clock} | {place.entity for place in places if place.dense}

    def place(self, signal: Signal) -> Place:
        """Where `signal` is."""
        if signal.field in CLOCKS:
            return Place(self.clock, 0, 1, True)
        if signal.field not in self._entities:
            return self._series[signal.field, signal.index[0] if signal.index else None]
        entity = self._entities[signal.field]
        column = int(np.ravel_multi_index(signal.index, record_dtype(Telemetry)[signal.field].shape))
        mirrored = entity in BACKBONES and signal.index[-1] == 1
        return Place(entity, column, -1 if mirrored else 1, False)


PIECE = 50_000
"""Rows that are in memory at once."""


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
    values: Values
    at: Values | None

    def part(self, first: int, end: int) -> tuple[Values, Values | None]:
        """Values at the rows from `first` up to `end`, and those rows counted from `first`."""
        if self.at is None:
            return self.values[first:end], None
        low, high = np.searchsorted(self.at, [first, end])
        return self.values[low:high], self.at[low:high] - first


@dataclass(frozen=True)
class Table:
    """Columns over the times `t_ns` (n,) since the recording's first row [ns, int64], which was at `wall_ns` [Unix]."""

    t_ns: Values
    wall_ns: int
    columns: Sequence[Column]
    bookmarks: Sequence[Bookmark] = ()
    """Of the whole window, of which the table may be a piece."""

    @cached_property
    def t(self) -> Values:
        """Times since the recording's first row (n,) [s]."""
        return np.asarray(self.t_ns / 1e9)

    def marked(self) -> dict[int, str]:
        """Number and label of the bookmarks at rows of this table, by row."""
        found: dict[int, list[str]] = {}
        for mark in self.bookmarks:
            row = int(np.searchsorted(self.t_ns, at := round(mark.t * 1e9)))
            if row < len(self.t_ns) and self.t_ns[row] == at:
                found.setdefault(row, []).append(f"{mark.n} {mark.label}".rstrip())
        return {row: "; ".join(texts) for row, texts in found.items()}


def table_of(rows: Rows) -> Table:
    """All that is known at any of `rows` (n,) of Telemetry, of a run whose clock has no date."""
    columns = []
    for signal in SIGNALS:
        place: Any = (slice(None), *signal.index)
        if not _unknown(rows[signal.field]):
            columns.append(Column(signal, rows[signal.field][place], None))
    return Table(rows["t_ns"] - rows["t_ns"][0], 0, columns)


def _unknown(values: Values) -> bool:
    return values.dtype.kind == "f" and bool(np.isnan(values).all())


def joined(tables: Iterable[Table]) -> Table:
    """One table of pieces that follow one another, at least one."""
    parts = list(tables)
    starts = np.cumsum([0, *(len(part.t_ns) for part in parts)])
    columns = []
    for place, pattern in enumerate(parts[0].columns):
        pieces = [part.columns[place] for part in parts]
        rows = [piece.at + start for piece, start in zip(pieces, starts[:-1], strict=True) if piece.at is not None]
        values = np.concatenate([piece.values for piece in pieces])
        columns.append(Column(pattern.signal, values, np.concatenate(rows) if rows else None))
    return Table(np.concatenate([part.t_ns for part in parts]), parts[0].wall_ns, columns, parts[0].bookmarks)


class RowReader:
    """Reads the rows of one recording from its file chunk by chunk."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def pieces(self, choice: Choice, told: ProgressCallback = no_progress, most: int = PIECE) -> Iterator[Table]:
        """What is asked for, `most` rows at a time, at least one piece; `told` is told the share that was used.

        ParameterError for an unknown signal or a window without rows; RecordingError when the file cannot be read or
        holds no rows.
        """
        with opened(self._path) as chunks:
            about = about_of(chunks, self._path)
            layout = Layout(about.profile)
            signals, survey = _looked_up(chunks, layout, choice.signals, TIP if about.info.rig == IMPORT_RIG else ())
            first, origin = int(survey.rows[0]), clock_origin(chunks)
            rows = survey.rows[_window(survey.rows - first, choice)]
            places = [(signal, layout.place(signal)) for signal in signals]
            start, stop = (rows[0] - first) * 1e-9, (rows[-1] - first) * 1e-9
            marks = [mark for mark in _bookmarks(self._path) if start <= mark.t <= stop]
            done = 0
            for t, parts in feed(chunks, survey, rows, most):
                piece = Piece(t, origin, parts, layout.clock)
                columns = [piece.column(signal, place) for signal, place in places]
                yield Table(t - first, origin + first + about.info.wall_offset_ns, columns, marks)
                done += len(t)
                told(done / len(rows))

    def table(self, choice: Choice) -> Table:
        """All of it at once; errors as `pieces`."""
        return joined(self.pieces(choice))


@dataclass(frozen=True)
class Piece:
    """Rows at the times `t` (n,) since `origin` [ns], as their entities hold them."""

    t: Values
    origin: int
    parts: Mapping[str, Part]
    clock: str

    def column(self, signal: Signal, place: Place) -> Column:
        """One signal of these rows."""
        if signal.field == "t_ns":
            return Column(signal, self.t + self.origin, None)
        if signal.field == "tick":
            return Column(signal, self.parts[self.clock].tick, None)
        kind = record_dtype(Telemetry)[signal.field].base
        if place.entity not in self.parts:
            return Column(signal, np.empty(0, kind), np.empty(0, np.intp))
        part = self.parts[place.entity]
        values = np.multiply(part.values[:, place.column], place.sign).astype(kind)
        return Column(signal, values, None if place.dense else np.searchsorted(self.t, part.t))


def _bookmarks(path: Path) -> Sequence[Bookmark]:
    """Those of its description; of data without one, as they were set."""
    try:
        return sidecar.read(path.parent, path.stem).bookmarks
    except RecordingError:
        return read_bookmarks(path)


def _looked_up(
    chunks: Chunks, layout: Layout, names: Sequence[str], only: Sequence[str]
) -> tuple[tuple[Signal, ...], Survey]:
    """The signals of these names, and the survey of their entities; ParameterError names one that is not there."""
    there = [signal for signal in SIGNALS if not only or signal.field in only]
    fields = {signal.field for signal in there if not names or {signal.name, signal.field} & set(names)}
    asked = [signal for signal in there if signal.field in fields]
    survey = surveyed(chunks, layout.components_of(asked), layout.dense(asked))
    if not len(survey.rows):
        raise RecordingError("the recording holds no rows")
    try:
        return chosen(names, _known(layout, asked, survey)), survey
    except ParameterError:  # the reason lists all that is there
        whole = surveyed(chunks, layout.components_of(there), layout.dense(there))
        chosen(names, _known(layout, there, whole))
        raise


def _known(layout: Layout, signals: Sequence[Signal], survey: Survey) -> set[str]:
    """The fields of which any value was recorded: a rig without a twin has no backbone of one.

    An older recording lacks what was added since, which is last in its entity.
    """
    places = [(signal.field, layout.place(signal)) for signal in signals]
    known = survey.known
    return {field for field, place in places if any(known.get(place.entity, ())[place.column : place.column + 1])}


def _window(t_ns: Values, choice: Choice) -> slice:
    """Which rows, at `t_ns` (n,) since the first one, are asked for."""
    length = t_ns[-1] / 1e9
    start, stop = (choice.start or 0.0), (length if choice.stop is None else choice.stop)
    if not 0.0 <= start <= length:
        raise ParameterError(f"from = {start:g} s is outside the recording's [0, {length:.3f}] s")
    if not start <= stop:
        raise ParameterError(f"to = {stop:g} s is before from = {start:g} s")
    seconds = t_ns / 1e9
    window = slice(int(np.searchsorted(seconds, start)), int(np.searchsorted(seconds, stop, side="right")))
    if window.start == window.stop:
        raise ParameterError(f"from = {start:g} s to {stop:g} s: the recording has no row there")
    return window
