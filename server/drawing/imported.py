"""A path from a file that the page was given: points, times, and what was understood of its columns and units."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import islice

import numpy as np

from controller.arrays import Array
from controller.errors import DataError
from controller.reference.path_file import (
    SI,
    UNTIMED,
    gap_note,
    path_table,
    placed_note,
    points_of,
    times_of,
    unused_note,
)
from controller.text.header import Column, Header, untitled
from controller.text.lines import Row, rows_in, sent_lines
from controller.text.table import Table, begun
from server.drawing.messages import (
    DURATION_MAX,
    DURATION_MIN,
    POINTS_MAX,
    ImportChoices,
    ImportedColumn,
    ImportedPath,
    ImportProposal,
    ProposedColumn,
    ProposedRow,
)
from server.drawing.picture import evenly

METRES_MAX = 2.0
"""Coordinates beyond this are in mm where no unit is said: the plane ends there [m]."""
ROWS_SHOWN, COLUMNS_SHOWN, CELL_SHOWN = 5, 50, 60
"""Of a proposal: first rows, columns, and characters of a cell."""


@dataclass(frozen=True)
class Understood:
    """All rows of a path as they were read."""

    table: Table
    units: Mapping[str, str]
    """Of t, if there is one, x and y."""
    p: Array
    """(n, 2) [m]."""
    t: Array | None
    """(n,) from the first row on [s]."""


def imported(text: bytes, choices: ImportChoices) -> ImportedPath:
    """The path in a file. DataError names line, column and value of what is wrong."""
    return _path(_understood(text, choices), choices)


def proposed(text: bytes, choices: ImportChoices) -> ImportProposal:
    """How the file would be imported; DataError where it is no table at all."""
    header, rows = _beginning(text, choices)
    try:
        found, problem = _understood(text, choices), ""
    except DataError as error:
        found, problem = None, str(error)
    return ImportProposal(
        header=header.named,
        columns=[_proposed_column(column, choices) for column in header.columns[:COLUMNS_SHOWN]],
        rows=[_proposed_row(row, place, found) for place, row in enumerate(rows)],
        count=0 if found is None else len(found.p),
        path=None if found is None else _path(found, choices),
        problem=problem,
        times_problem="" if found is None or found.t is None else _times_problem(float(found.t[-1])),
    )


def _understood(text: bytes, choices: ImportChoices) -> Understood:
    where = choices.name
    table = path_table(sent_lines(text, where), where, timed=False, numbers=_numbers(choices))
    units = _units(table, choices)
    p = points_of(table, units)
    t = times_of(table, units["t"]) if "t" in units else None
    if not np.ptp(p, axis=0).any():
        x, y = p[0]
        raise DataError(f"{where}: all {len(p)} rows are at x = {x:g} m, y = {y:g} m, which is no path")
    return Understood(table, units, p, None if t is None else t - t[0])


def _numbers(choices: ImportChoices) -> dict[str, int]:
    said = {"t": choices.t, "x": choices.x, "y": choices.y}
    return {name: number for name, number in said.items() if number is not None}


def _path(found: Understood, choices: ImportChoices) -> ImportedPath:
    kept = evenly(len(found.p), POINTS_MAX)
    return ImportedPath(
        points=[(x, y) for x, y in found.p[kept].tolist()],
        times=None if found.t is None else found.t[kept].tolist(),
        header=found.table.header.named,
        columns=[_column(column, found.units) for column in found.table.columns],
        notes=[*_notes(found, choices), *_thinned(len(found.p))],
    )


def _units(table: Table, choices: ImportChoices) -> dict[str, str]:
    """The unit of each column that is there: of its title, else as chosen, else of the other axis, else a guess."""
    stated = {column.name: column.unit for column in table.columns}
    length = choices.length_unit or stated["x"] or stated["y"] or _guess(table)
    return {name: unit or (choices.time_unit or "s" if name == "t" else length) for name, unit in stated.items()}


def _guess(table: Table) -> str:
    return "mm" if any((np.abs(table.values(axis)) > METRES_MAX).any() for axis in "xy") else "m"


def _column(column: Column, units: Mapping[str, str]) -> ImportedColumn:
    return ImportedColumn(name=column.name, title=column.title, unit=units[column.name], stated=column.unit is not None)


def _chosen_unit(name: str, choices: ImportChoices) -> str | None:
    return choices.time_unit if name == "t" else choices.length_unit


def _notes(found: Understood, choices: ImportChoices) -> Iterator[str]:
    """What the file does not say, and what is left of it."""
    if not _numbers(choices):
        yield from placed_note(found.table)
    for column in found.table.columns:
        if column.unit is None and _chosen_unit(column.name, choices) is None:
            yield f"{column.name} has no unit: taken as {found.units[column.name]}{_why(found, column)}"
    yield from unused_note(found.table)
    if found.t is not None:
        yield from gap_note(found.table, found.t)


def _why(found: Understood, column: Column) -> str:
    """How the unit of a length was found that no title says."""
    if column.name == "t":
        return ""
    if any(one.unit for one in found.table.columns if one.name in "xy"):
        return ", as the other axis"
    return f", as some values are beyond {METRES_MAX:g}" if found.units["x"] == "mm" else ""


def _thinned(count: int) -> list[str]:
    return [f"thinned from {count} points to {POINTS_MAX}"] if count > POINTS_MAX else []


def _times_problem(seconds: float) -> str:
    if DURATION_MIN <= seconds <= DURATION_MAX:
        return ""
    return f"the file lasts {seconds:g} s, a drawing {DURATION_MIN:g} to {DURATION_MAX:g} s"


def _beginning(text: bytes, choices: ImportChoices) -> tuple[Header, list[Row]]:
    """The columns as far as they are known, and the first rows."""
    where, numbers = choices.name, _numbers(choices)
    try:
        header, rows = begun(sent_lines(text, where), where, UNTIMED, numbers)
    except DataError:
        rows = rows_in(sent_lines(text, where), where)
        first = next(rows, None)
        if first is None or numbers:
            raise
        return untitled(len(first.cells), where, first.line), [first, *islice(rows, ROWS_SHOWN - 1)]
    return header, list(islice(rows, ROWS_SHOWN))


def _proposed_column(column: Column, choices: ImportChoices) -> ProposedColumn:
    title = (column.title or f"column {column.at + 1}")[:CELL_SHOWN]
    if column.name not in SI:
        return ProposedColumn(title=title, name=None, unit=None, stated=False)
    stated = column.fits and column.unit is not None
    unit = column.unit if stated else _chosen_unit(column.name, choices)
    return ProposedColumn(title=title, name=column.name, unit=unit, stated=stated)


def _proposed_row(row: Row, place: int, found: Understood | None) -> ProposedRow:
    cells = [cell[:CELL_SHOWN] for cell in row.cells[:COLUMNS_SHOWN]]
    if found is None or place >= len(found.p):
        return ProposedRow(line=row.line, cells=cells, t=None, point=None)
    x, y = found.p[place].tolist()
    return ProposedRow(line=row.line, cells=cells, t=None if found.t is None else float(found.t[place]), point=(x, y))
