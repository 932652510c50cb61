"""A table of numbers, read from its text: the columns that are wanted, in SI units, every number checked."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from controller.arrays import Array, Words
from controller.errors import DataError
from controller.tables.header import Column, Header, Places, placed, titled
from controller.tables.lines import Numbers, Row, is_number, rows_in

Choice = Callable[[Header], Sequence[Column]]
"""Which columns are read; cells of the others may be anything."""


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


def read_table(lines: Iterable[str], where: str, choose: Choice, places: Places) -> Table:
    """The table in `lines`; `places` says what its columns are where it has no header.

    Raises DataError with `where`, line, column and value of the first thing that is wrong.
    """
    rows = rows_in(lines, where)
    first = next(rows, None)
    if first is None:
        needed = f"columns {', '.join(places[max(places)])}" if places else "a header and rows of numbers"
        raise DataError(f"{where} is empty: {needed} are needed")
    named = not any(is_number(cell, first.comma) for cell in first.cells)
    header = titled(first.cells, where) if named else placed(len(first.cells), places, where)
    columns, numbers = tuple(choose(header)), Numbers(where)
    at, values = [], []
    for row in rows if named else chain([first], rows):
        _require_width(row, header)
        at.append(row.line)
        values.append([numbers.read(row, column.at, column.title) for column in columns])
    return Table(header, columns, np.array(at, np.int64), np.array(values, np.float64).reshape(len(at), len(columns)))


def _require_width(row: Row, header: Header) -> None:
    """DataError for a row with fewer or more cells than there are columns."""
    count, width = len(row.cells), len(header.columns)
    place = f"{header.where}, line {row.line}: {count} values"
    if count < width:
        raise DataError(f"{place}, but {header.columns[count].title} is column {count + 1}")
    if count > width:
        owner = "the header has" if header.named else "the first row has"
        raise DataError(f"{place}, {owner} {width} columns: {row.cells[width][:60]!r} is in none")
