"""`tendril track` at the command line: how well a path is followed, as a table and as JSON."""

import json
from pathlib import Path

from rich.console import Console
from rich.table import Table

from controller.errors import TendrilError
from controller.experiments.metrics import UNITS
from controller.experiments.track import Facts, Task, Tracked, figures, track

MENTIONED = 5
"""More times than so many are only counted."""


def run_track(task: Task, json_file: Path | None, console: Console) -> None:
    """Run, show, and write what is asked for; TendrilError says what is wrong, or why the rig broke the run off."""
    if json_file is not None and not json_file.absolute().parent.is_dir():
        raise TendrilError(f"{json_file} cannot be written: its folder does not exist")
    with console.status("Tracking ..."):
        tracked = track(task)
    show(tracked, console)
    if json_file is not None:
        try:
            json_file.write_text(json.dumps(figures(tracked), indent=2, allow_nan=False) + "\n")
        except OSError as error:
            raise TendrilError(f"{json_file} cannot be written: {error.strerror}") from error
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
    table = Table(title=f"{task.actuator.name}, {task.law}", title_justify="left", box=None, pad_edge=False)
    for head in ("metric", *map(str, tracked.windows), "unit"):
        table.add_column(head, justify="left" if head in ("metric", "unit") else "right")
    for metric in UNITS:
        values = [metrics[metric] for metrics in tracked.windows.values() if metric in metrics]
        if values:
            table.add_row(metric, *(f"{value:.3g}" for value in values), UNITS[metric][0])
    console.print(table, highlight=False)


def described(facts: Facts) -> list[str]:
    """Sentences about a reference."""
    rhythm = "no period found" if facts.frequency is None else f"{facts.frequency:g} Hz"
    before = f"{facts.approach:g} s of approach before" if facts.approach else "from rest, no approach"
    feedforward = "on" if facts.velocity_feedforward else "off"
    lines = [
        f"{facts.name}: {facts.duration:.4g} s, {1e3 * facts.length:.4g} mm, up to {facts.peak_speed:.3g} m/s; "
        f"{rhythm}; {before}; velocity feedforward {feedforward}"
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
