"""A path of the tip from a CSV file with columns t, x, y: by name with units, or without a header in this order."""

import csv
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import numpy as np

from controller.arrays import Array
from controller.errors import DataError

UNITS = {
    "t": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    **{axis: {"m": 1.0, "cm": 1e-2, "mm": 1e-3} for axis in "xy"},
}
"""What a column's unit multiplies."""
SI = {"t": "s", "x": "m", "y": "m"}
"""The unit of a column that names none, where nothing else is said."""
NAMES = {"t": "t", "time": "t", "x": "x", "y": "y"}
"""Names of the columns that are read, in lower case; any other column is left alone."""
HEADER_SHOWN = 20
"""Names of a header that an error quotes."""
DELIMITERS = ";\t,"
"""In the order in which they are looked for; without any of them a row is split at blanks."""


@dataclass(frozen=True)
class Samples:
    """Points of a path at their times, as the file has them."""

    path: Path
    t: Array
    """(n,) [s], rising."""
    p: Array
    """(n, 2) [m]."""
    lines: np.ndarray
    """(n,) the line of the file from which each came."""


class ColumnPlace(NamedTuple):
    """Where one of t, x, y is."""

    name: str
    """As the header has it."""
    at: int
    unit: float
    """[s] or [m]."""


def read_samples(path: Path, units: Mapping[str, str] = SI) -> Samples:
    """The whole file: at least two rows, t rising; `units` of t, x and y hold where the header names none.

    Lines that are blank or begin with # are left out. Raises DataError with file, line, column and value of the first
    thing that is wrong.
    """
    rows = _rows(path)
    first = next(rows, None)
    if first is None:
        raise DataError(f"{path} is empty: columns t, x, y are needed")
    columns = _columns(path, first[1], units)
    values, lines = [], []
    for number, cells in rows if _is_header(first[1]) else chain([first], rows):
        values.append([_number(f"{path}, line {number}", column, cells) for column in columns])
        lines.append(number)
    if len(values) < 2:
        raise DataError(f"{path}: a path needs at least 2 rows of numbers, there are {len(values)}")
    table = np.array(values) * [column.unit for column in columns]
    samples = Samples(path, table[:, 0], table[:, 1:], np.array(lines))
    _require_rising(samples)
    return samples


def _rows(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Line numbers and cells."""
    delimiter = None
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            for number, line in enumerate(file, 1):
                if not line.strip() or line.lstrip().startswith("#"):
                    continue
                if delimiter is None:
                    delimiter = next((one for one in DELIMITERS if one in line), " ")
                yield number, _cells(line, delimiter)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise DataError(f"{path} cannot be read: {error}") from error


def _cells(line: str, delimiter: str) -> list[str]:
    """Cells of a line; between semicolons a number may have a decimal comma."""
    if delimiter == " ":
        return line.split()
    cells = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))
    return [cell.replace(",", ".") for cell in cells] if delimiter == ";" else cells


def _is_header(cells: list[str]) -> bool:
    """Whether no cell of the first row is a number."""
    return not any(_is_number(cell) for cell in cells)


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def _columns(path: Path, first: list[str], units: Mapping[str, str]) -> list[ColumnPlace]:
    """Columns t, x, y, as the first row says."""
    if not _is_header(first):
        if len(first) != 3:
            raise DataError(f"{path} has no header and {len(first)} columns: three (t, x, y) are needed, or a header")
        return [ColumnPlace(name, index, UNITS[name][units[name]]) for index, name in enumerate("txy")]
    found: dict[str, ColumnPlace] = {}
    strange: dict[str, str] = {}
    for index, title in enumerate(map(str.strip, first)):
        name, unit = _split(title, units)
        if name and unit not in UNITS[name]:
            strange.setdefault(name, title)
        elif name in found:
            raise DataError(f"{path}: the header names {name} twice ({found[name].name!r} and {title!r})")
        elif name:
            found[name] = ColumnPlace(title, index, UNITS[name][unit])
    for name in "txy":
        if name not in found:
            raise DataError(f"{path}: {_missing(name, strange, first)}")
    return [found[name] for name in "txy"]


def _split(title: str, units: Mapping[str, str]) -> tuple[str, str]:
    """Which of t, x, y a title like "x", "X_mm", "x [mm]" or "time (s)" means, and its unit; "" for any other."""
    match = re.fullmatch(r"([a-z]+)(?:[\s_]*[\[(/ _]\s*([a-z]+)\s*[\])]?)?", title.lower())
    if match is None or match[1] not in NAMES:
        return "", ""
    name = NAMES[match[1]]
    return name, match[2] or units[name]


def _missing(name: str, strange: dict[str, str], header: list[str]) -> str:
    """Why there is no column `name`: perhaps one of `strange` was meant, by name."""
    if name in strange:
        return f"column {strange[name]!r} has an unknown unit (known for {name}: {', '.join(UNITS[name])})"
    return f"column {name} is missing (the header has {_begin(header)})"


def _begin(header: list[str]) -> str:
    """The first names of a header that may be no header at all."""
    names = [title.strip()[:40] for title in header[:HEADER_SHOWN]]
    return ", ".join(names) + (f", and {len(header) - len(names)} more" if len(header) > len(names) else "")


def _number(where: str, column: ColumnPlace, cells: list[str]) -> float:
    """The finite number in `column`."""
    if column.at >= len(cells):
        raise DataError(f"{where}: {len(cells)} values, but {column.name} is column {column.at + 1}")
    text = cells[column.at].strip()
    if not text:
        raise DataError(f"{where}: {column.name} is empty")
    try:
        value = float(text)
    except ValueError:
        raise DataError(f"{where}: {column.name} = {text[:60]!r} is not a number") from None
    if not math.isfinite(value):
        raise DataError(f"{where}: {column.name} = {text[:60]} is not finite")
    return value


def _require_rising(samples: Samples) -> None:
    """DataError at the first time that is not after the one before."""
    stays = np.flatnonzero(np.diff(samples.t) <= 0.0)
    if stays.size:
        i = int(stays[0]) + 1
        raise DataError(
            f"{samples.path}, line {samples.lines[i]}: t = {samples.t[i]:.9g} s is not after "
            f"{samples.t[i - 1]:.9g} s of line {samples.lines[i - 1]}"
        )
