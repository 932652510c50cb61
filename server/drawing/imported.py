"""A path from a file that the page was given: points, times, and what was understood of its columns and units."""

from collections.abc import Iterator

import numpy as np

from controller.arrays import Array
from controller.reference.path_file import path_table, points_of, times_of
from controller.tables.header import Column
from controller.tables.lines import sent_lines
from controller.tables.table import Table
from server.drawing.messages import POINTS_MAX, ImportedColumn, ImportedPath
from server.drawing.picture import evenly

METRES_MAX = 2.0
"""Coordinates beyond this are in mm where no unit is said: the plane ends there [m]."""
LEFT_SHOWN = 5
"""Columns that are left alone and named."""


def imported(text: bytes, where: str) -> ImportedPath:
    """The path in a file that errors call `where`. DataError names line, column and value of what is wrong."""
    table = path_table(sent_lines(text, where), where, timed=False)
    units = _units(table)
    p = points_of(table, units)
    t = times_of(table, units["t"]) if "t" in units else None
    kept = evenly(len(p), POINTS_MAX)
    return ImportedPath(
        points=[(x, y) for x, y in p[kept].tolist()],
        times=None if t is None else (t - t[0])[kept].tolist(),
        header=table.header.named,
        columns=[_column(column, units) for column in table.columns],
        notes=[*_notes(table, units), *_thinned(len(p))],
    )


def _units(table: Table) -> dict[str, str]:
    """The unit of each column that is there: what its title says, of x and y else that of the other, else a guess."""
    stated = {column.name: column.unit for column in table.columns}
    length = stated["x"] or stated["y"] or _guess(np.abs(np.column_stack([table.values(axis) for axis in "xy"])))
    return {name: unit or ("s" if name == "t" else length) for name, unit in stated.items()}


def _guess(sizes: Array) -> str:
    return "mm" if (sizes > METRES_MAX).any() else "m"


def _column(column: Column, units: dict[str, str]) -> ImportedColumn:
    return ImportedColumn(name=column.name, title=column.title, unit=units[column.name], stated=column.unit is not None)


def _notes(table: Table, units: dict[str, str]) -> Iterator[str]:
    """What the file does not say, and what is left of it."""
    if not table.header.named:
        yield f"no header: the columns are {', '.join(column.name for column in table.columns)}"
    for column in table.columns:
        if column.unit is None:
            yield f"{column.name} has no unit: taken as {units[column.name]}{_why(table, column, units)}"
    left = [one.title for one in table.header.columns if one not in table.columns]
    if left:
        more = f" and {len(left) - LEFT_SHOWN} more" if len(left) > LEFT_SHOWN else ""
        yield f"not used: {', '.join(left[:LEFT_SHOWN])}{more}"


def _why(table: Table, column: Column, units: dict[str, str]) -> str:
    """How the unit of a length was found that no title says."""
    if column.name == "t":
        return ""
    if any(one.unit for one in table.columns if one.name in "xy"):
        return ", as the other axis"
    return f", as some values are beyond {METRES_MAX:g}" if units["x"] == "mm" else ""


def _thinned(count: int) -> list[str]:
    return [f"thinned from {count} points to {POINTS_MAX}"] if count > POINTS_MAX else []
