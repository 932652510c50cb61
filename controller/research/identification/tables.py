"""Measured data as CSV files with a header (docs/identification.md): every column by name, every number checked."""

import csv
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from controller.arrays import Array
from controller.errors import DataError

UNITS = {"pa": 1.0, "kpa": 1e3, "m": 1.0, "mm": 1e-3, "s": 1.0, "ms": 1e-3}
"""What a column's suffix multiplies: `p1_kpa` is p1 in kPa. Without a suffix a column is in SI units."""

FITTING = {"p": ("pa", "kpa"), "t": ("s", "ms"), **dict.fromkeys("xyz", ("m", "mm"))}
"""Units that a column may have, by its first letter."""


@dataclass(frozen=True)
class MeasuredTable:
    """Columns (n,) by name in SI units, and the line of the file that each row came from."""

    path: Path
    columns: dict[str, Array]
    lines: Array

    def need(self, name: str) -> Array:
        """The column `name`; DataError names it when it is missing."""
        if name not in self.columns:
            raise DataError(f"{self.path}: column {name} is missing (the header has {', '.join(self.columns)})")
        return self.columns[name]

    def need_rows(self, least: int, what: str) -> None:
        """DataError unless there are at least `least` rows."""
        if self.lines.size < least:
            raise DataError(f"{self.path}: {self.lines.size} rows are too few, {what} needs at least {least}")


def read_table(path: Path) -> MeasuredTable:
    """The whole file; DataError names file, line, column and value of the first thing that is not a finite number."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            lines = [(number, line) for number, line in enumerate(file, 1) if line.strip() and line.lstrip()[0] != "#"]
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"{path} cannot be read: {error}") from error
    if not lines:
        raise DataError(f"{path} is empty: a header and rows of numbers are needed")
    names = [name.strip() for name in _cells(path, *lines[0])]
    columns = [_plain_name(path, name) for name in names]
    if len(set(columns)) < len(columns):
        raise DataError(f"{path}: the header names a column twice ({', '.join(names)})")
    rows = [_numbers(path, number, names, line) for number, line in lines[1:]]
    values = np.array(rows, np.float64).reshape(len(rows), len(names)) * [_unit(name) for name in names]
    at = np.array([number for number, _ in lines[1:]], np.float64)
    return MeasuredTable(path, dict(zip(columns, values.T, strict=True)), at)


def points_in(table: MeasuredTable, axes: str) -> Array:
    """Tracked points (n, bodies, len(axes)) [m] from columns x1, y1, .. x2, y2, ..; DataError where one is missing."""
    numbers = {int(name[1:]) for name in table.columns if name[0] in axes and name[1:].isdecimal()} - {0}
    if not numbers:
        raise DataError(f"{table.path}: column {axes[0]}1 is missing (the header has {', '.join(table.columns)})")
    bodies = range(1, max(numbers) + 1)
    return np.stack([np.stack([table.need(f"{axis}{i}") for axis in axes], axis=-1) for i in bodies], axis=1)


def choose_ids(text: str | None, present: Sequence[int], path: Path) -> list[int]:
    """Those of the IDs `present` that `text` names, as in "0-16,20"; all without a text.

    DataError when a single ID is not there, or none of a range, or when the text is no such list.
    """
    available = sorted(set(present))
    if text is None:
        return available
    chosen: set[int] = set()
    for part in text.split(","):
        match = re.fullmatch(r"\s*(\d+)(?:\s*-\s*(\d+))?\s*", part)
        if match is None:
            raise DataError(f"ids = {text!r}: {part!r} is neither a number nor a range like 0-16")
        first, last = int(match[1]), int(match[2] or match[1])
        if first > last:
            raise DataError(f"ids = {text!r}: {part.strip()} begins after its end")
        found = {one for one in available if first <= one <= last}
        if not found:
            raise DataError(f"{path}: ID {part.strip()} is not there (IDs {available[0]} to {available[-1]} are)")
        chosen |= found
    return sorted(chosen)


def _plain_name(path: Path, name: str) -> str:
    """The name without its unit, as in x1 for X1_mm."""
    plain, _, unit = name.partition("_")
    if not plain:
        raise DataError(f"{path}: column {name!r} has no name (a comma too many in the header?)")
    if unit and unit.lower() not in UNITS:
        raise DataError(f"{path}: column {name!r} has an unknown unit (known: {', '.join(UNITS)})")
    known = FITTING.get(plain[0].lower(), ())
    if unit and unit.lower() not in known:
        raise DataError(f"{path}: column {name!r} is not measured in {unit} (but in {', '.join(known) or 'no unit'})")
    return "ID" if plain.lower() == "id" else plain.lower()


def _unit(name: str) -> float:
    return UNITS[name.partition("_")[2].lower() or "s"]


def _cells(path: Path, number: int, line: str) -> list[str]:
    try:
        return next(csv.reader([line]))
    except csv.Error as error:
        raise DataError(f"{path}, line {number}: {error}") from error


def _numbers(path: Path, number: int, names: list[str], line: str) -> list[float]:
    cells = _cells(path, number, line)
    if len(cells) != len(names):
        raise DataError(f"{path}, line {number}: {len(cells)} values, the header has {len(names)} columns")
    return [_number(path, number, name, cell) for name, cell in zip(names, cells, strict=True)]


def _number(path: Path, number: int, name: str, cell: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        raise DataError(f"{path}, line {number}: {name} = {cell.strip()!r} is not a number") from None
    if not math.isfinite(value):
        raise DataError(f"{path}, line {number}: {name} = {cell.strip()} is not finite")
    return value
