"""From a file to rows of cells, and from a cell to its number."""

import csv
import io
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from controller.errors import DataError

DELIMITERS = ";\t,"
"""In the order in which they are looked for; without any of them a row is split at blanks."""
QUOTES = re.compile(r'"[^"]*"')
REMARKS = ("#", "%")
"""How lines begin that are no rows."""
WORD = re.compile(r"[^ \t\r\n\v\f]+")
"""Of a row that is split at blanks; a blank that does not break may part thousands, and splits nothing."""
UPPER = r"[^\W\d_a-z]"
LOST = re.compile(rf"\s*#(?:(?:{UPPER}/{UPPER}|NV|[¡A-Z][^\s;,]*[!?])(?=[;,\t]|\s+[-+.\d#])|#*(?=[;,\t]))")
"""What spreadsheets write for a number that they do not have, in the first cell of a row: no remark."""
KINDS = (
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"GIF8", "a GIF picture"),
    (b"%PDF", "a PDF document"),
    (b"PK\x03\x04", "an archive, as .xlsx and .ods files are"),
    (b"\xd0\xcf\x11\xe0", "an Office document"),
    (b"\x1f\x8b", "a compressed file"),
    (b"BZh", "a compressed file"),
    (b"7z\xbc\xaf", "a compressed file"),
    (b"{\\rtf", "an RTF document"),
    (b"%!PS", "a PostScript document"),
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
UNCLOSED = "a quote is not closed in this line: cells may not go over several"


class Row(NamedTuple):
    """One row of a table."""

    line: int
    """Of the file, from 1 on."""
    cells: list[str]
    """Without the blanks around them."""
    delimiter: str
    """What parts the cells, a blank for any number of blanks and tabs."""
    remarks: tuple[tuple[int, str], ...] = ()
    """Of the first row: the lines above it that are none, with their numbers."""


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
    """The rows; blank lines and those that begin with # or % are left out. DataError where it is not CSV."""
    delimiter, remarks = "", []
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        if line.lstrip().startswith(REMARKS) and not LOST.match(line):
            if not delimiter:
                remarks.append((number, line))
            continue
        place = f"{where}, line {number}"
        _require_text(line, place)
        above = () if delimiter else tuple(remarks)
        delimiter = delimiter or _delimiter(line)
        try:
            yield Row(number, _cells(line, delimiter), delimiter, above)
        except csv.Error as error:
            raise DataError(f"{place}: {error}") from error


def titles_in(remark: str, delimiter: str) -> list[str]:
    """The cells of a remark whose rows are parted by `delimiter`, which it may do without; none where it is not CSV."""
    text = remark.strip().lstrip("".join(REMARKS)).strip(" ")
    try:
        return _cells(text, delimiter if delimiter in text else _delimiter(text))
    except csv.Error:
        return []


def _delimiter(line: str) -> str:
    unquoted = QUOTES.sub("", line)
    return next((one for one in DELIMITERS if one in unquoted), " ")


def _require_text(line: str, place: str) -> None:
    """DataError for a line that holds bytes which are no text in UTF-8."""
    if "\0" in line:
        raise DataError(f"{place}: a zero byte, which is no text: {REMEDY}")
    wrong = None if line.isascii() else ESCAPED.search(line)
    if wrong:
        raise DataError(f"{place}: byte 0x{ord(wrong[0]) - 0xDC00:02x} is not UTF-8: {REMEDY}")


def _cells(line: str, delimiter: str) -> list[str]:
    if delimiter == " ":
        if line.lstrip().startswith('"') and line.count('"') % 2:
            raise csv.Error(UNCLOSED)
        return WORD.findall(re.sub(r"\s+(?=[\[(])", "", line))  # a unit in brackets belongs to the name before it
    if '"' not in line:
        return [cell.strip() for cell in line.split(delimiter)]
    reader = csv.reader([line, ""], delimiter=delimiter, skipinitialspace=True)
    cells = [cell.strip() for cell in next(reader)]
    if reader.line_num > 1:
        raise csv.Error(UNCLOSED)
    return cells
