"""A table of numbers, read from its text: the columns that are wanted, in SI units, every number checked."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from types import MappingProxyType

import numpy as np

from controller.arrays import Array, Words
from controller.errors import DataError
from controller.tables.header import Column, Header, Numbers, Places, placed, titled, untitled
from controller.tables.lines import Cells, Row, is_number, rows_in

Choice = Callable[[Header], Sequence[Column]]
"""Which columns are read; cells of the others may be anything."""
AS_THE_HEADER: Mapping[str, int] = MappingProxyType({})
"""Nobody said which column is which."""


@dataclass(frozen=True)
class Table:
    """The columns that were chosen, n rows of them."""

    header: Header
    columns: tuple[Column, ...]
    lines: Words
    """(n,) the line of the file from which each row came."""
    numbers: Array
    """(n, columns), as the file has them."""

    @property
    def where(self) -> str:
        """What errors call it."""
        return self.header.where

    def find(self, name: str) -> Column | None:
        """The chosen column `name`; None where it was not chosen."""
        return next((column for column in self.columns if column.name == name), None)

    def values(self, name: str, unit: str | None = None) -> Array:
        """The chosen column `name` (n,) in SI; `unit` holds where the header names none, and without that SI."""
        place, column = next((place, one) for place, one in enumerate(self.columns) if one.name == name)
        return np.asarray(self.numbers[:, place] * column.factor(unit))


def read_table(
    lines: Iterable[str], where: str, choose: Choice, places: Places, numbers: Numbers = AS_THE_HEADER
) -> Table:
    """The table in `lines`; `places` says what its columns are where it has no header, and `numbers` against both.

    Raises DataError with `where`, line, column and value of the first thing that is wrong.
    """
    header, rows = begun(lines, where, places, numbers)
    columns, cells = tuple(choose(header)), Cells(where)
    at, values = [], []
    for row in rows:
        _require_width(row, header)
        at.append(row.line)
        values.append([cells.read(row, column.at, column.title) for column in columns])
    cells.require_sure()
    return Table(header, columns, np.array(at, np.int64), np.array(values, np.float64).reshape(len(at), len(columns)))


def begun(lines: Iterable[str], where: str, places: Places, numbers: Numbers) -> tuple[Header, Iterator[Row]]:
    """The header of the table in `lines`, and its rows; DataError as `read_table`."""
    rows = rows_in(lines, where)
    first = next(rows, None)
    if first is None:
        needed = f"columns {', '.join(places[max(places)])}" if places else "a header and rows of numbers"
        raise DataError(f"{where} is empty: {needed} are needed")
    if not any(is_number(cell) for cell in first.cells):
        header = titled(first.cells, where, first.line)
    else:
        width, rows = len(first.cells), chain([first], rows)
        known = width in places or not numbers
        header = placed(width, places, where, first.line) if known else untitled(width, where, first.line)
    return (header.assigned(numbers) if numbers else header), rows


def _require_width(row: Row, header: Header) -> None:
    """DataError for a row with fewer or more cells than there are columns."""
    count, width = len(row.cells), len(header.columns)
    place = f"{header.where}, line {row.line}: {count} values"
    if count < width:
        raise DataError(f"{place}, but {header.columns[count].title} is column {count + 1}")
    if count > width:
        owner = "the header has" if header.named else "the first row has"
        raise DataError(f"{place}, {owner} {width} columns: {row.cells[width][:60]!r} is in none")
