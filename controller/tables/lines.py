"""From text to rows of cells, and from a cell to its number."""

import csv
import io
import math
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from controller.errors import DataError

DELIMITERS = ";\t,"
"""In the order in which they are looked for; without any of them a row is split at blanks."""
MARKS = {",": "comma", ".": "point"}
"""What may part the decimals; the comma only between semicolons."""
QUOTED = 60
"""Characters of a wrong cell that an error quotes."""


class Row(NamedTuple):
    """One row of a table."""

    line: int
    """Of the file, from 1 on."""
    cells: list[str]
    """Without the blanks around them."""
    comma: bool
    """Whether a number may have a decimal comma: between semicolons."""


def file_lines(path: Path) -> Iterator[str]:
    """The lines of a file in UTF-8; DataError when it cannot be read as that."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            yield from file
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"{path} cannot be read: {error}") from error


def sent_lines(text: bytes, where: str) -> Iterator[str]:
    """The lines of a file in UTF-8 that was sent; DataError, which calls it `where`, when it is none."""
    try:
        yield from io.StringIO(text.decode("utf-8-sig"), newline="")
    except UnicodeDecodeError as error:
        raise DataError(f"{where} cannot be read: {error}") from error


def rows_in(lines: Iterable[str], where: str) -> Iterator[Row]:
    """The rows; blank lines and those that begin with # are left out. DataError where it is not CSV."""
    delimiter = ""
    for number, line in enumerate(lines, 1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        delimiter = delimiter or next((one for one in DELIMITERS if one in line), " ")
        try:
            yield Row(number, _cells(line, delimiter), delimiter == ";")
        except csv.Error as error:
            raise DataError(f"{where}, line {number}: {error}") from error


def _cells(line: str, delimiter: str) -> list[str]:
    if delimiter == " ":
        return re.sub(r"\s+(?=[\[(])", "", line).split()  # a unit in brackets belongs to the name before it
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))]


def is_number(cell: str, comma: bool) -> bool:
    """Whether `cell` is meant to be a number, finite or not."""
    try:
        _value(cell, comma)
    except ValueError:
        return False
    return True


class Numbers:
    """Reads the cells of one table. DataError names line, column and value of the first that is not a finite number."""

    def __init__(self, where: str) -> None:
        self._where = where
        self._mark, self._marked = "", ""
        """The first decimal mark, and where it stands."""

    def read(self, row: Row, at: int, title: str) -> float:
        """The number in cell `at`, whose column is called `title`."""
        cell = row.cells[at]
        try:
            value = _value(cell, row.comma)
        except ValueError:
            what = f"= {cell[:QUOTED]!r} is not a number" if cell else "is empty"
            raise DataError(f"{self._where}, line {row.line}: {title} {what}") from None
        if not math.isfinite(value):
            raise DataError(f"{self._where}, line {row.line}: {title} = {cell[:QUOTED]} is not finite")
        if row.comma:
            self._require_one_mark(cell, row.line, title)
        return value

    def _require_one_mark(self, cell: str, line: int, title: str) -> None:
        """DataError where both points and commas occur: either may part thousands."""
        mark = next((one for one in MARKS if one in cell), None)
        if mark is None:
            return
        told = f"{title} = {cell[:QUOTED]!r}"
        if not self._mark:
            self._mark, self._marked = mark, f"line {line}: {told}"
        if mark != self._mark:
            has = f"has a decimal {MARKS[mark]}, but a {MARKS[self._mark]} is in {self._marked}"
            raise DataError(f"{self._where}, line {line}: {told} {has}")


def _value(cell: str, comma: bool) -> float:
    """ValueError unless it is a number; Python's own 1_000 is not."""
    if "_" in cell:
        raise ValueError(cell)
    return float(cell.replace(",", ".") if comma else cell)
