"""A path of the tip from a table with columns t, x, y (docs/tables.md)."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from controller.arrays import Array, Words
from controller.errors import DataError
from controller.text.header import Column, Header, Numbers
from controller.text.lines import file_lines
from controller.text.table import AS_THE_HEADER, Table, read_table

SI = {"t": "s", "x": "m", "y": "m"}
"""The unit of a column that names none, where nothing else is said."""
TIMED, UNTIMED = {3: "txy"}, {2: "xy", 3: "txy"}
"""What the columns are where there is no header; in the second a path may also come without times."""
SECONDS_MAX = 1e6
"""Length of a path [s]: eleven days."""
FAR = 1e3
"""Largest coordinate of a path [m]."""
LEFT_SHOWN = 5
"""Columns that are left alone and named."""
GAP, GAP_ROWS = 10.0, 4
"""A gap is this many times longer than the median step, in a path of at least this many rows."""


@dataclass(frozen=True)
class Samples:
    """Points of a path at their times, as the file has them."""

    path: Path
    t: Array
    """(n,) [s], rising."""
    p: Array
    """(n, 2) [m]."""
    lines: Words
    """(n,) the line of the file from which each came."""
    notes: tuple[str, ...] = ()
    """What the file does not say and was taken for granted, what was left alone, and gaps."""


def read_samples(path: Path, units: Mapping[str, str] = SI) -> Samples:
    """The whole file: at least two rows, t rising; `units` of t, x and y hold where the header names none.

    Raises DataError with file, line, column and value of the first thing that is wrong.
    """
    return samples_in(file_lines(path), path, units)


def samples_in(lines: Iterable[str], path: Path, units: Mapping[str, str] = SI) -> Samples:
    """As `read_samples`, of a file whose lines are here already and which errors call `path`."""
    table = path_table(lines, str(path))
    table.header.require_alike([column for column in table.columns if units[column.name] == SI[column.name]])
    t = times_of(table, units["t"])
    unsaid = [column.name for column in table.columns if column.unit is None]
    assumed = [f"{name} has no unit: taken as {units[name]}" for name in unsaid]
    notes = (*placed_note(table), *assumed, *unused_note(table), *gap_note(table, t))
    return Samples(path, t, points_of(table, units), table.lines, notes)


def placed_note(table: Table) -> list[str]:
    """Where there is no header: what the columns are."""
    names = ", ".join(column.name for column in table.columns)
    return [] if table.header.named else [f"no header: the columns are {names}"]


def unused_note(table: Table) -> list[str]:
    """Which columns are left alone."""
    left = [one.title or f"column {one.at + 1}" for one in table.header.columns if one not in table.columns]
    more = f" and {len(left) - LEFT_SHOWN} more" if len(left) > LEFT_SHOWN else ""
    return [f"not used: {', '.join(left[:LEFT_SHOWN])}{more}"] if left else []


def gap_note(table: Table, t: Array) -> list[str]:
    """Where the longest step of the times `t` (n,) [s] is, if it is much longer than the others."""
    if len(t) < GAP_ROWS:
        return []
    steps = np.diff(t)
    place, usual = int(np.argmax(steps)), float(np.median(steps))
    if steps[place] <= GAP * usual:
        return []
    return [f"gap of {steps[place]:.6g} s before line {table.lines[place + 1]}, others are of {usual:.6g} s"]


def path_table(lines: Iterable[str], where: str, timed: bool = True, numbers: Numbers = AS_THE_HEADER) -> Table:
    """Columns t, x, y of at least two rows; unless `timed` there may be no t. `numbers` says which they are."""
    choose, places = (_timed, TIMED) if timed else (_untimed, UNTIMED)
    table = read_table(lines, where, choose, places, numbers)
    if len(table.lines) < 2:
        raise DataError(f"{where}: a path needs at least 2 rows of numbers, there are {len(table.lines)}")
    return table


def times_of(table: Table, unit: str) -> Array:
    """(n,) [s], rising; `unit` holds where the header names none. DataError also for what takes too long."""
    t = table.values("t", unit)
    with np.errstate(over="ignore"):
        late, stays = t - t[0], np.flatnonzero(np.diff(t) <= 0.0)
    if stays.size:
        i = int(stays[0]) + 1
        raise DataError(
            f"{table.where}, line {table.lines[i]}: t = {t[i]:.9g} s is not after "
            f"{t[i - 1]:.9g} s of line {table.lines[i - 1]}"
        )
    _require_at_most(SECONDS_MAX, table, "t", late, "s after the first line")
    return t


def points_of(table: Table, units: Mapping[str, str]) -> Array:
    """(n, 2) [m]; `units` of x and y hold where the header names none. DataError also for what is too far away."""
    p = np.column_stack([table.values(axis, units[axis]) for axis in "xy"])
    for axis, values in zip("xy", p.T, strict=True):
        _require_at_most(FAR, table, axis, np.abs(values), "m")
    return p


def _timed(header: Header) -> list[Column]:
    return [header.need(name) for name in "txy"]


def _untimed(header: Header) -> list[Column]:
    t = header.find("t")
    return [*([t] if t else []), header.need("x"), header.need("y")]


def _require_at_most(bound: float, table: Table, name: str, values: Array, unit: str) -> None:
    """DataError at the first of `values` [unit] beyond `bound`."""
    beyond = np.flatnonzero(values > bound)
    if beyond.size:
        place = f"{table.where}, line {table.lines[beyond[0]]}"
        raise DataError(f"{place}: {name} = {values[beyond[0]]:.6g} {unit}, more than {bound:g}")
