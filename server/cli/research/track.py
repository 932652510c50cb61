"""`tendril track` at the command line: how well a path is followed, as a table and as JSON.

Beside the figures it writes every number of the run, and a drawing of it for a paper.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Console

from controller.arrays import Rows
from controller.errors import ParameterError, TendrilError
from controller.research.track import Facts, Tracked, TrackTask, figures, track
from controller.schema.origin import Origin, hashes, origin_of_rig
from controller.schema.palette import LINES, MEASURED, REFERENCE, css
from controller.schema.parameters import DT
from controller.simulation.metrics import UNITS, tip
from controller.system.origin import command_line
from controller.system.progress import progress
from server.cli.files import require_file, write_json
from server.cli.tables import empty, number

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MENTIONED = 5
"""More times than these are only counted."""
OUT, PLOT = (".csv", ".parquet", ".rrd"), (".svg", ".pdf")
WIDE = (7.0, 2.8)
"""Across both columns of a paper [inch]."""


@dataclass(frozen=True)
class Wanted:
    """Which files are to be written."""

    json_file: Path | None = None
    out: Path | None = None
    plot: Path | None = None
    comments: bool = False
    """At the head of a CSV file."""


def run_track(task: TrackTask, wanted: Wanted, console: Console) -> None:
    """Run, show, and write what is asked for; TendrilError says what is wrong, or why the rig broke the run off."""
    if wanted.json_file is not None:
        require_file(wanted.json_file)
    require_files(wanted.out, wanted.plot)
    read = hashes([task.file])
    with progress(console, "Tracking") as told:
        tracked = track(task, told)
    show(tracked, console)
    made = origin_of_rig(tracked.parameters, command_line(), settings=tracked.settings, files=read)
    for path in deliver(tracked, wanted, made):
        console.print(f"Written: {path}", markup=False, soft_wrap=True, highlight=False)
    if tracked.failed:
        raise TendrilError(tracked.failed)


def deliver(tracked: Tracked, wanted: Wanted, made: Origin) -> Iterator[Path]:
    """Write what is asked for, each path as soon as it is there; of a broken run the figures alone."""
    if wanted.json_file is not None:
        write_json(wanted.json_file, figures(tracked), made)
        yield wanted.json_file
    if tracked.rows is None:
        return
    if wanted.out is not None:
        write_rows(tracked, tracked.rows, wanted.out, made, wanted.comments)
        yield wanted.out
    if wanted.plot is not None:
        write_plot(tracked, tracked.rows, wanted.plot, made)
        yield wanted.plot


def show(tracked: Tracked, console: Console) -> None:
    """What the reference is, and the metrics in both windows."""
    task = tracked.task
    for line in (*tracked.notes, *described(tracked.reference)):
        console.print(line, markup=False, soft_wrap=True, highlight=False)
    if tracked.learned:
        console.print(f"Learned: RMSE {', '.join(map(learned_text, tracked.learned))} mm", highlight=False)
    if tracked.failed:
        return
    windows = tuple(map(str, tracked.windows))
    table = empty(f"{task.actuator.name}, {task.law}", ("metric", *windows, "unit"), windows)
    for metric in UNITS:
        values = [metrics.get(metric) for metrics in tracked.windows.values()]
        if any(value is not None for value in values):
            table.add_row(metric, *map(number, values), UNITS[metric][0])
    console.print(table, highlight=False)


def learned_text(rmse: float) -> str:
    """Of one repeat, rmse in m."""
    return "stop" if math.isnan(rmse) else number(1e3 * rmse)


def course(facts: Facts) -> str:
    """Whether it steps or repeats."""
    if facts.steps:
        return f"{facts.steps} step{'s' * (facts.steps > 1)}" + (f", {facts.frequency:g} Hz" if facts.frequency else "")
    if facts.frequency is None:
        return "no period found"
    if facts.axis_frequencies is None:
        return f"{facts.frequency:g} Hz"
    x, y = facts.axis_frequencies
    return f"{facts.frequency:g} Hz (x swings at {x:g} Hz, y at {y:g} Hz)"


def lead(facts: Facts) -> str:
    """What comes before the shape."""
    if not facts.approach:
        return "from rest, no approach"
    if not facts.own_approach:
        return f"{facts.approach:.4g} s of approach before"
    own = f"its first {facts.own_approach:.4g} s (--start says otherwise)"
    if facts.own_approach == facts.approach:
        return f"{own} are the approach"
    return f"{facts.approach:.4g} s of approach, with {own}"


def described(facts: Facts) -> list[str]:
    """Sentences about a reference."""
    feedforward = "on" if facts.velocity_feedforward else "off"
    lines = [
        f"{facts.name}: {facts.duration:.4g} s, {1e3 * facts.length:.4g} mm, up to {facts.peak_speed:.3g} m/s; "
        f"{course(facts)}; {lead(facts)}; velocity feedforward {feedforward}"
    ]
    if facts.projected_share > 0.0:
        lines.append(
            f"{100 * facts.projected_share:.3g} % of it is out of reach, by up to {1e3 * facts.projected_most:.3g} mm: "
            "errors are those to the nearest points within reach"
        )
    if facts.branch_changes:
        times = ", ".join(f"{t:.4g}" for t in facts.branch_changes[:MENTIONED])
        more = f" and {len(facts.branch_changes) - MENTIONED} more" if len(facts.branch_changes) > MENTIONED else ""
        lines.append(f"{times}{more} s after its first point it can only go on in another pose of the arm")
    if facts.off_path_seconds:
        lines.append(f"For {facts.off_path_seconds:.3g} s the loop led the tip off the path on the way to another pose")
    return lines


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
