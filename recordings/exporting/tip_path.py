"""A recorded path in the plane, as something that can be followed again."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from controller.arrays import Values
from controller.errors import ParameterError
from controller.schema.parameters import SENSORS
from recordings.exporting.table import Choice, RowReader
from recordings.read.metrics import followed
from recordings.read.reader import read_rows

JUST = 1e-6
"""Rounding of times [s]."""

What = Literal["p_meas", "p_ref", "marker"]


@dataclass(frozen=True)
class Wanted:
    """Which path, in which window [s since the recording's first row]; `rod` 1.. counts for a marker only.

    `run`: from the first to the last row that figures are taken of, without what came before a run, led into it or came
    after it; all of it where there was none.
    """

    what: What = "p_meas"
    rod: int = SENSORS
    start: float | None = None
    stop: float | None = None
    run: bool = False


def run_window(source: Path) -> tuple[float | None, float | None]:
    """When the figures' first and last row were [s since the recording's first row]; None where there are none."""
    rows = read_rows(source, ("mode",))
    t = 1e-9 * (followed(rows)["t_ns"] - rows["t_ns"][:1])
    return (max(0.0, float(t[0]) - JUST), float(t[-1]) + JUST) if len(t) else (None, None)


def tip_path(source: Path, wanted: Wanted) -> tuple[Values, Values]:
    """Times (k,) [s], from 0 on, and points (k, 2) [m] where it was seen, k >= 2; ParameterError without them."""
    name = f"markers_{wanted.rod}" if wanted.what == "marker" else wanted.what
    start, stop = run_window(source) if wanted.run else (wanted.start, wanted.stop)
    table = RowReader(source).table(Choice((f"{name}_x", f"{name}_y"), start, stop))
    x, y = table.columns
    t = table.t if x.at is None else table.t[x.at]
    p = np.stack([x.values, y.values], axis=1)
    seen = np.isfinite(p).all(axis=1)
    if seen.sum() < 2:
        raise ParameterError(f"what = {name}: it was seen at {seen.sum()} times in this window, a path needs 2")
    return t[seen] - t[seen][0], p[seen]


def write_path(source: Path, target: Path, wanted: Wanted, before: str = "") -> None:
    """The path as the CSV file that `tendril track` reads: t, x, y in s and m, t to the nanosecond, x and y to 1 nm.

    `before` are lines of comments.
    """
    t, p = tip_path(source, wanted)
    table = np.column_stack([t, p])
    np.savetxt(target, table, fmt=("%.9f", "%.9f", "%.9f"), delimiter=",", header=f"{before}t_s,x_m,y_m", comments="")
