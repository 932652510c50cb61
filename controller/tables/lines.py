"""From a file to rows of cells, and from a cell to its number."""

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
"""What may part the decimals."""
THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")
"""What a comma makes of a number that may be of thousands as well as of thousandths."""
MINUS = "\N{MINUS SIGN}"
QUOTED = 60
"""Characters of a wrong cell that an error quotes."""
KINDS = (
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"GIF8", "a GIF picture"),
    (b"%PDF", "a PDF document"),
    (b"PK\x03\x04", "an archive, as .xlsx and .ods files are"),
    (b"\xd0\xcf\x11\xe0", "an Office document"),
    (b"\x1f\x8b", "a compressed file"),
    (b"PAR1", "a Parquet file"),
    (b"\x89HDF", "an HDF5 file"),
    (b"MATLAB 5.0", "a MATLAB file"),
    (b"\x93NUMPY", "a numpy array"),
    (b"\xff\xfe", "text in UTF-16"),
    (b"\xfe\xff", "text in UTF-16"),
    (b"{", "JSON"),
    (b"[", "JSON"),
    (b"<", "XML or HTML"),
)
"""How files begin that are no table of numbers in text."""
BEGINNING = 64
"""Bytes that are looked at for that."""
ESCAPED = re.compile("[\udc80-\udcff]")
"""What stands for bytes that are not UTF-8."""
REMEDY = "save it as CSV in UTF-8"


class Row(NamedTuple):
    """One row of a table."""

    line: int
    """Of the file, from 1 on."""
    cells: list[str]
    """Without the blanks around them."""
    semicolons: bool
    """Whether they part the cells: a comma can then only part decimals."""


def file_lines(path: Path) -> Iterator[str]:
    """The lines of a file; DataError when it cannot be read, or is of a kind that is no table."""
    try:
        with path.open("rb") as file:
            yield from _lines(file, str(path))
    except OSError as error:
        raise DataError(f"{path} cannot be read: {error}") from error


def sent_lines(text: bytes, where: str) -> Iterator[str]:
    """As `file_lines`, of a file that was sent, which errors call `where`."""
    return _lines(io.BufferedReader(io.BytesIO(text)), where)


def _lines(file: io.BufferedReader, where: str) -> Iterator[str]:
    first = file.peek(BEGINNING).removeprefix(b"\xef\xbb\xbf").lstrip()
    kind = next((kind for beginning, kind in KINDS if first.startswith(beginning)), None)
    if kind is not None:
        raise DataError(f"{where} is {kind}, not a table of numbers in text: {REMEDY}")
    with io.TextIOWrapper(file, encoding="utf-8-sig", errors="surrogateescape", newline="") as text:
        yield from text


def rows_in(lines: Iterable[str], where: str) -> Iterator[Row]:
    """The rows; blank lines and those that begin with # are left out. DataError where it is not CSV."""
    delimiter = ""
    for number, line in enumerate(lines, 1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        place = f"{where}, line {number}"
        _require_text(line, place)
        delimiter = delimiter or next((one for one in DELIMITERS if one in line), " ")
        try:
            yield Row(number, _cells(line, delimiter), delimiter == ";")
        except csv.Error as error:
            raise DataError(f"{place}: {error}") from error


def _require_text(line: str, place: str) -> None:
    """DataError for a line that holds bytes which are no text in UTF-8."""
    if "\0" in line:
        raise DataError(f"{place}: a zero byte, which is no text: {REMEDY}")
    wrong = None if line.isascii() else ESCAPED.search(line)
    if wrong:
        raise DataError(f"{place}: byte 0x{ord(wrong[0]) - 0xDC00:02x} is not UTF-8: {REMEDY}")


def _cells(line: str, delimiter: str) -> list[str]:
    if delimiter == " ":
        return re.sub(r"\s+(?=[\[(])", "", line).split()  # a unit in brackets belongs to the name before it
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))]


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
        self._unsure: str | None = None
        """What may be thousands, as long as no other cell shows what a comma parts."""

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
            self._look_at_mark(mark, row, f"{title} = {cell[:QUOTED]!r}", THOUSANDS.fullmatch(cell) is not None)
        return value

    def _look_at_mark(self, mark: str, row: Row, told: str, unsure: bool) -> None:
        """DataError where both points and commas occur: either may part thousands."""
        if not self._mark:
            self._mark, self._marked = mark, f"line {row.line}: {told}"
            self._unsure = f"line {row.line}: {told}" if mark == "," and not row.semicolons else None
        if mark != self._mark:
            has = f"has a decimal {MARKS[mark]}, but a {MARKS[self._mark]} is in {self._marked}"
            raise DataError(f"{self._where}, line {row.line}: {told} {has}")
        if not unsure:
            self._unsure = None

    def require_sure(self) -> None:
        """DataError where every comma of the table may part thousands as well as decimals."""
        if self._unsure is not None:
            raise DataError(
                f"{self._where}, {self._unsure} may be thousands or have a decimal comma: "
                "write decimal points, or part the cells by semicolons"
            )


def _value(cell: str) -> float:
    """ValueError unless it is a number; Python's own 1_000 is not."""
    if "_" in cell:
        raise ValueError(cell)
    return float(cell.replace(",", ".").replace(MINUS, "-"))
