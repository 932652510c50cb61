"""A table of numbers, read from its text: the columns that are wanted, in SI units, every number checked."""

import math
import re
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from types import MappingProxyType

import numpy as np

from controller.arrays import Array, Words
from controller.errors import DataError
from controller.text.header import Column, Header, Numbers, Places, placed, titled, untitled
from controller.text.lines import Row, rows_in, titles_in

MARKS = {",": "comma", ".": "point"}
"""What may part the decimals."""
GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}")
"""A number that may be of thousands as well as of thousandths."""
UNGROUPED = re.compile(r"[+-]?[1-9]\d{0,2}")
"""What may stand beside numbers of thousands."""
MINUS = "\N{MINUS SIGN}"
QUOTED = 60
"""Characters of a wrong cell that an error quotes."""


def is_number(cell: str) -> bool:
    """Whether `cell` is meant to be a number, finite or not."""
    try:
        _value(cell)
    except ValueError:
        return False
    return True


class Cells:
    """Reads the cells of one table. DataError names line, column and value of the first that is not a finite number."""

    def __init__(self, where: str) -> None:
        self._where = where
        self._mark, self._marked = "", ""
        """The first decimal mark, and where it stands."""
        self._delimiter = ""
        """What parts the cells of the row with the first mark."""
        self._all_grouped = True
        """Whether every mark so far may part thousands."""
        self._grouped: set[int] = set()
        self._ungrouped: set[int] = set()
        """Columns that have such numbers."""

    def read(self, row: Row, at: int, title: str) -> float:
        """The number in cell `at`, whose column is called `title`."""
        cell = row.cells[at]
        try:
            value = _value(cell)
        except ValueError:
            what = f"= {cell[:QUOTED]!r} is not a number" if cell else "is empty"
            raise DataError(f"{self._where}, line {row.line}: {title} {what}") from None
        if not math.isfinite(value):
            raise DataError(f"{self._where}, line {row.line}: {title} = {cell[:QUOTED]} is not finite")
        mark = next((one for one in MARKS if one in cell), None)
        if mark is not None:
            self._look_at_mark(mark, row, at, f"{title} = {cell[:QUOTED]!r}")
        elif self._all_grouped and UNGROUPED.fullmatch(cell):
            self._ungrouped.add(at)
        return value

    def _look_at_mark(self, mark: str, row: Row, at: int, told: str) -> None:
        """DataError where both points and commas occur: either may part thousands."""
        if not self._mark:
            self._mark, self._marked, self._delimiter = mark, f"line {row.line}: {told}", row.delimiter
        if mark != self._mark:
            has = f"has a decimal {MARKS[mark]}, but a {MARKS[self._mark]} is in {self._marked}"
            raise DataError(f"{self._where}, line {row.line}: {told} {has}")
        if self._all_grouped:
            self._all_grouped = GROUPED.fullmatch(row.cells[at]) is not None
            self._grouped.add(at)

    def require_sure(self) -> None:
        """DataError where every mark of the table may part thousands as well as decimals.

        A comma may where no semicolon parts the cells. Any mark may in a column where it is not in all numbers, as in
        998 and 1.002; only a point between commas may not.
        """
        bare_comma = self._mark == "," and self._delimiter != ";"
        point_between_commas = self._mark == "." and self._delimiter == ","
        mixed = bool(self._grouped & self._ungrouped) and not point_between_commas
        if not self._mark or not self._all_grouped or not (bare_comma or mixed):
            return
        remedy = "write decimal points, or part the cells by semicolons" if bare_comma else "write thousands without it"
        raise DataError(
            f"{self._where}, {self._marked} may be thousands or have a decimal {MARKS[self._mark]}: {remedy}"
        )


def _value(cell: str) -> float:
    """ValueError unless it is a number; Python's own 1_000 is not."""
    if "_" in cell:
        raise ValueError(cell)
    return float(cell.replace(",", ".").replace(MINUS, "-"))


Choice = Callable[[Header], Sequence[Column]]
"""Which columns are read; cells of the others may be anything."""
AS_THE_HEADER: Mapping[str, int] = MappingProxyType({})
"""No one said which column is which."""
NAMED_LEAST = 2
"""Fewer titles may be words of a sentence, fewer numbers need not count."""


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
    at, values = array("q"), array("d")  # lists of what a long file holds take ten times as much
    for row in rows:
        _require_width(row, header)
        at.append(row.line)
        values.extend([cells.read(row, column.at, column.title) for column in columns])
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
        header, rows = _with_units(titled(first.cells, where, first.line), rows)
    else:
        header, rows = _without_titles(first, rows, where, places, numbers)
    return (header.assigned(numbers) if numbers else header), rows


def _with_units(header: Header, rows: Iterator[Row]) -> tuple[Header, Iterator[Row]]:
    """With the units of the row below, where that is one of units."""
    second = next(rows, None)
    if second is None:
        return header, rows
    united = None if any(is_number(cell) for cell in second.cells) else header.united(second.cells)
    return (header, chain([second], rows)) if united is None else (united, rows)


def _without_titles(
    first: Row, rows: Iterator[Row], where: str, places: Places, numbers: Numbers
) -> tuple[Header, Iterator[Row]]:
    """The columns of a table whose first row has a number: as a remark above it names them, else by their places."""
    width, second = len(first.cells), next(rows, None)
    _require_no_counting(first, second, where)
    rows = chain([first], rows if second is None else chain([second], rows))
    remarked = _remarked(first, where)
    if remarked is not None:
        return remarked, rows
    known = width in places or not numbers
    return placed(width, places, where, first.line) if known else untitled(width, where, first.line), rows


def _remarked(first: Row, where: str) -> Header | None:
    """The titles that numpy and MATLAB write into a remark: one for each cell below, two known ones at least.

    DataError where a remark under them has as many words, which may be their units.
    """
    under = None
    for line, remark in reversed(first.remarks):
        cells = titles_in(remark, first.delimiter)
        if len(cells) != len(first.cells) or any(is_number(cell) for cell in cells):
            continue
        header = titled(cells, where, line)
        if sum(bool(column.units) for column in header.columns) >= NAMED_LEAST:
            if under is not None:
                raise DataError(
                    f"{where}, line {under}: is this a remark or units? They stand behind the names, as in x [mm]"
                )
            return header
        under = line
    return None


def _require_no_counting(first: Row, second: Row | None, where: str) -> None:
    """DataError where the first row counts the columns, as pandas does for those without names."""
    titles = [cell for cell in first.cells if cell]
    counts = len(titles) >= NAMED_LEAST and titles == [str(place) for place in range(len(titles))]
    if counts and second is not None and all("." in cell for cell in second.cells[-len(titles) :]):
        raise DataError(
            f"{where}, line {first.line}: {', '.join(titles)} may be the numbers of the columns or the first row: "
            "name the columns, or write decimals"
        )


def _require_width(row: Row, header: Header) -> None:
    """DataError for a row with fewer or more cells than there are columns."""
    count, width = len(row.cells), len(header.columns)
    place = f"{header.where}, line {row.line}: {count} values" if count != 1 else _single(row, header.where)
    if count < width:
        raise DataError(f"{place}, but {header.columns[count].title} is column {count + 1}")
    if count > width:
        owner = "the header has" if header.named else "the first row has"
        raise DataError(f"{place}, {owner} {width} columns: {row.cells[width][:60]!r} is in none")


def _single(row: Row, where: str) -> str:
    parted = {" ": "blanks", "\t": "tabs", ",": "commas", ";": "semicolons"}[row.delimiter]
    return f"{where}, line {row.line}: one value, {row.cells[0][:60]!r}, between {parted} as in the first line"
