"""`tendril track` at the command line: how well a path is followed, as a table and as JSON."""

import json
from pathlib import Path

from rich.console import Console

from controller.errors import TendrilError
from controller.research.track import Facts, Tracked, TrackTask, figures, track
from controller.simulation.metrics import UNITS
from controller.system.progress import progress
from server.cli.files import require_file, write
from server.cli.tables import empty, number

MENTIONED = 5
"""More times than these are only counted."""


def run_track(task: TrackTask, json_file: Path | None, console: Console) -> None:
    """Run, show, and write what is asked for; TendrilError says what is wrong, or why the rig broke the run off."""
    if json_file is not None:
        require_file(json_file)
    with progress(console, "Tracking") as told:
        tracked = track(task, told)
    show(tracked, console)
    if json_file is not None:
        write(json_file, json.dumps(figures(tracked), indent=2, allow_nan=False) + "\n")
        console.print(f"Written: {json_file}", markup=False, soft_wrap=True, highlight=False)
    if tracked.failed:
        raise TendrilError(tracked.failed)


def show(tracked: Tracked, console: Console) -> None:
    """What the reference is, and the metrics in both windows."""
    task = tracked.task
    for line in described(tracked.reference):
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
