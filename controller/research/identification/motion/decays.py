"""Free decays of tracked bodies, as they stand in a file (docs/identification.md): one decay per ID."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from controller.arrays import Array
from controller.errors import DataError
from controller.research.identification.tables import MeasuredTable, choose_ids, points_in, read_measured

SAMPLE_S = 0.01
"""Between samples, where the file has no column t [s]."""

SAMPLES_MIN = 150
"""A decay of no more samples than this ends before it has come to rest, and is neither fitted nor scored."""


WAY_MAX_M = 4.0
"""No body of an arm moves by more: twice the longest [m]."""


@dataclass(frozen=True)
class Decay:
    """One release and what followed, n samples of every body in the file's coordinates."""

    id: int
    t: Array
    """(n,) from 0 [s]."""
    points: Array
    """(n,bodies,2) or (n,bodies,3) [m]."""


def is_decay(table: MeasuredTable) -> bool:
    """True for a table of free decays."""
    return "ID" in table.columns


def read_decays(path: Path, ids: str | None = None) -> list[Decay]:
    """The decays of `path` that `ids` names, as in "0-16,20"; DataError says what is wrong with file or IDs."""
    return decays_in(read_measured(path), ids)


def decays_in(table: MeasuredTable, ids: str | None = None) -> list[Decay]:
    """The decays in `table` that `ids` names; each one's rows must stand together."""
    column = table.need("ID")
    table.need_rows(1, "a decay")
    if (broken := np.flatnonzero(column != np.round(column))).size:
        raise DataError(f"{table.path}, line {table.lines[broken[0]]:.0f}: ID = {column[broken[0]]} is not whole")
    axes = "xyz" if "z1" in table.columns else "xy"
    points = points_in(table, axes)
    _refuse_far(table, points)
    _refuse_strangers(table, axes, points.shape[1])
    starts = [int(row) for row in np.flatnonzero(np.diff(column, prepend=np.nan) != 0)]
    _refuse_split(table, column, starts)
    chosen = choose_ids(ids, [int(one) for one in column[starts]], table.path)
    return [
        Decay(int(column[first]), _times(table, slice(first, last)), points[first:last])
        for first, last in zip(starts, [*starts[1:], column.size], strict=True)
        if int(column[first]) in chosen
    ]


def long_ones(decays: list[Decay], what: str, path: Path) -> list[Decay]:
    """Decays of more than SAMPLES_MIN samples; DataError when none is left."""
    kept = [one for one in decays if len(one.t) > SAMPLES_MIN]
    if not kept:
        found = ", ".join(f"ID {one.id}: {len(one.t)}" for one in decays)
        raise DataError(f"{path}: no decay to {what} has more than {SAMPLES_MIN} samples ({found})")
    return kept


def _times(table: MeasuredTable, rows: slice) -> Array:
    if "t" not in table.columns:
        return SAMPLE_S * np.arange(rows.stop - rows.start)
    t = table.columns["t"][rows]
    if (back := np.flatnonzero(np.diff(t) <= 0.0)).size:
        line = table.lines[rows][back[0] + 1]
        raise DataError(f"{table.path}, line {line:.0f}: t = {t[back[0] + 1]} s does not come after {t[back[0]]} s")
    return np.asarray(t - t[0])


def _refuse_far(table: MeasuredTable, points: Array) -> None:
    """Millimetres without a unit would make an arm of 100 m."""
    body, way = max(enumerate(np.ptp(points, axis=0).max(axis=-1)), key=lambda one: float(one[1]))
    if way > WAY_MAX_M:
        raise DataError(
            f"{table.path}: body {body + 1} moves by {way:.4g} m, more than {WAY_MAX_M:g} m: write the unit behind the "
            f"name, as in x{body + 1} [mm]"
        )


def _refuse_split(table: MeasuredTable, column: Array, starts: Sequence[int]) -> None:
    seen: set[float] = set()
    for row in starts:
        if column[row] in seen:
            raise DataError(f"{table.path}, line {table.lines[row]:.0f}: ID {column[row]:.0f} has begun further up")
        seen.add(float(column[row]))


def _refuse_strangers(table: MeasuredTable, axes: str, bodies: int) -> None:
    known = {"ID", "t"} | {f"{axis}{i + 1}" for axis in axes for i in range(bodies)}
    if strange := [name for name in table.columns if name not in known]:
        raise DataError(f"{table.path}: column {strange[0]} is unknown in free decays (ID[, t], x1, y1[, z1], ..)")
