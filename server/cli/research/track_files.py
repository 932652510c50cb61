"""What `tendril track` writes beside its figures: every number of the run, and a drawing of it for a paper."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from controller.arrays import Rows
from controller.errors import ParameterError, TendrilError
from controller.research.track import Tracked
from controller.schema.origin import Origin
from controller.schema.palette import LINES, MEASURED, REFERENCE, css
from controller.schema.parameters import DT
from controller.simulation.metrics import tip
from server.cli.files import require_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure

OUT, PLOT = (".csv", ".parquet", ".rrd"), (".svg", ".pdf")
WIDE = (7.0, 2.8)
"""Across both columns of a paper [inch]."""


def require_files(out: Path | None, plot: Path | None) -> None:
    """Raise ParameterError for a kind that is not written, TendrilError for a place that takes nothing."""
    for name, path, kinds in (("out", out, OUT), ("plot", plot, PLOT)):
        if path is not None:
            if path.suffix not in kinds:
                raise ParameterError(f"{name} = {str(path)!r} ends in none of {', '.join(kinds)}")
            require_file(path)


def write_rows(tracked: Tracked, rows: Rows, path: Path, origin: Origin, comments: bool) -> None:
    """Every tick of the run, approach included, in the format that `path` ends in; `rows` (n,) of Telemetry."""
    if path.suffix == ".rrd":
        from recordings.write.run_file import write_every_row

        task = tracked.task
        name = f"{tracked.reference.name} {task.actuator.name} {task.law}, seed {task.seed}"
        return write_every_row(rows, path, name, tracked.parameters, tracked.settings)
    from recordings.exporting.arrow import write_csv, write_parquet
    from recordings.exporting.table import table_of

    try:
        if path.suffix == ".csv":
            write_csv([table_of(rows)], path, origin if comments else None)
        else:
            write_parquet([table_of(rows)], path, origin)
    except OSError as error:
        raise TendrilError(f"{path} cannot be written: {error.strerror or error}") from error


def write_plot(tracked: Tracked, rows: Rows, path: Path, origin: Origin) -> None:
    """Path and tip in the plane, and the error over time, at the width of a page; `rows` (n,) of Telemetry."""
    from controller.research.drawing import save

    save(drawn(tracked, rows), path, WIDE, origin.model_dump_json())


def drawn(tracked: Tracked, rows: Rows) -> "Callable[[Figure], None]":
    """How a figure of the run is drawn; millimetres, and seconds from the first point of the shape on."""
    begin = tracked.path.start
    t = (np.arange(len(rows)) - begin) * DT
    wanted, actual = 1e3 * tracked.path.p, 1e3 * tip(rows)
    error = wanted - actual

    def draw(figure: "Figure") -> None:
        plane, errors = figure.subplots(1, 2, width_ratios=(1.0, 1.6))
        plane.plot(*wanted[begin:].T, color=css(REFERENCE), linewidth=2.0, label="reference")
        plane.plot(*actual[begin:].T, color=css(MEASURED), linewidth=0.8, label="tip")
        plane.set(xlabel="x [mm]", ylabel="y [mm]", aspect="equal")
        plane.legend()
        for axis, (name, colour) in enumerate(zip("xy", LINES[:2], strict=True)):
            errors.plot(t, error[:, axis], color=css(colour), linewidth=0.8, label=f"e_{name}")
        errors.axvline(0.0, color="#777777", linewidth=0.6, linestyle=":")
        errors.set(xlabel="t [s]", ylabel="error, reference minus tip [mm]", xlim=(t[0], max(t[-1], t[0] + DT)))
        errors.legend()

    return draw
