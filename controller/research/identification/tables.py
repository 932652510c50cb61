"""Measured data as tables with a header (docs/identification.md, docs/tables.md): every column by name."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from controller.arrays import Array
from controller.errors import DataError
from controller.text.header import Header
from controller.text.lines import file_lines
from controller.text.table import read_table


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


def read_measured(path: Path) -> MeasuredTable:
    """The whole file; DataError names file, line, column and value of the first thing that is not a finite number."""
    table = read_table(file_lines(path), str(path), Header.every, places={})
    table.header.require_alike(table.columns)
    columns = {column.name: table.values(column.name) for column in table.columns}
    return MeasuredTable(path, columns, table.lines.astype(np.float64))


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
