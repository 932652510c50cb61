"""`tendril track` at the command line: how well a path is followed, as a table and as JSON."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from controller.errors import TendrilError
from controller.research.track import Facts, Tracked, TrackTask, figures, track
from controller.schema.origin import Origin, hashes, origin_of_rig
from controller.simulation.metrics import UNITS
from controller.system.origin import command_line
from controller.system.progress import progress
from server.cli.files import require_file, write_json
from server.cli.research.track_files import require_files, write_plot, write_rows
from server.cli.tables import empty, number

MENTIONED = 5
"""More times than these are only counted."""


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
    if tracked.failed:
        return
    windows = tuple(map(str, tracked.windows))
    table = empty(f"{task.actuator.name}, {task.law}", ("metric", *windows, "unit"), windows)
    for metric in UNITS:
        values = [metrics.get(metric) for metrics in tracked.windows.values()]
        if any(value is not None for value in values):
            table.add_row(metric, *map(number, values), UNITS[metric][0])
    console.print(table, highlight=False)


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
