"""`tendril calibrate` at the command line: progress while it searches, then the fit and what it leaves open."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeElapsedColumn
from rich.table import Table

from controller.research.calibration.calibrate import CalibrationTask, calibrate
from controller.research.calibration.ensemble import FITS_MIN
from controller.research.calibration.fit_file import Result, fit_text, ratio, require_toml
from controller.research.calibration.search import Report, Stage
from controller.research.calibration.spread import coverage, discrepancy
from controller.system.progress import remaining, say
from server.cli.files import require_file, write
from server.cli.tables import empty

AT_BOUND = 0.01
"""Nearer to a bound than this share of the box counts as being there."""


def run_calibrate(task: CalibrationTask, out: Path | None, console: Console) -> None:
    """Search, write and show. Raises TendrilError for a file that cannot be written, before the search if possible."""
    if out is not None:
        require_toml(out)
        require_file(out)
    with progress(console) as report:
        result = calibrate(task, report)
    try:
        if out is not None:
            write(out, fit_text(result))
    finally:
        show(result, console)  # all that is left of a long search if the disk is full
    if out is not None:
        console.print(f"Written: {out}", markup=False, soft_wrap=True, highlight=False)


@contextmanager
def progress(console: Console) -> Iterator[Report]:
    """One bar a stage, with the best cost so far; at no terminal one line a stage instead."""
    best = TextColumn("{task.fields[best]}")
    counted = TextColumn("{task.description:<16}"), BarColumn(), MofNCompleteColumn()
    columns = *counted, best, TimeElapsedColumn(), remaining()
    tasks: dict[Stage, TaskID] = {}
    say(console, "Searching; the first time the kernels are compiled")
    with Progress(*columns, console=console) as bars:

        def report(stage: Stage, cost: float) -> None:
            for other in tasks.keys() - {stage}:
                bars.stop_task(tasks[other])
            text = f"best cost {cost:.2f}" if math.isfinite(cost) else "no margins kept yet"
            if stage not in tasks:
                say(console, f"{stage.name}: {stage.most} at most, {text}")
                tasks[stage] = bars.add_task(stage.name, total=stage.most, best="")
            bars.update(tasks[stage], advance=1, best=text)

        yield report


def show(result: Result, console: Console) -> None:
    """Rows, unknowns, margins and spread of a fit."""
    origin = result.origin
    console.print(
        f"Cost {result.best.cost:.2f} after {origin.evaluations} points in {origin.seconds:.0f} s ({origin.ended}); "
        f"{len(result.fits)} near-equal fits.",
        highlight=False,
    )
    if result.spread:
        inside, rows = coverage(result.spread)
        size = discrepancy(result.problem.rows, result.fits)
        console.print(
            f"Discrepancy of {size:.2f} deviations; the paper is in the interval of {inside} of {rows} fit rows "
            f"= {100 * inside / max(1, rows):.0f} %.",
            highlight=False,
        )
    if len(result.fits) < FITS_MIN:
        console.print(f"[yellow]Note[/]: below {FITS_MIN} near-equal fits an interval says little.", highlight=False)
    tables = rows_table(result), unknowns_table(result), margins_table(result), spread_table(result)
    for table in tables:
        if table.row_count:
            console.print(table)


def rows_table(result: Result) -> Table:
    """The rows that were fitted."""
    numbers = ("paper", "ours", "ratio")
    table = empty("Fitted rows", ("row", *numbers, "unit"), numbers)
    for row, (ours, _) in zip(result.problem.rows, result.best.predicted, strict=True):
        table.add_row(" ".join(row.key), f"{row.paper}", f"{ours:.2f}", f"{ratio(row, ours):.2f}", row.unit)
    return table


def unknowns_table(result: Result) -> Table:
    """The numbers that were found, beside what was believed before; over all near-equal fits, too."""
    numbers = ("fit", "near-equal fits", "prior", "bounds")
    space = result.problem.space
    table = empty("Unknowns", ("name", *numbers, ""), numbers)
    values, others = space.values(result.best.z), [space.values(fit.z) for fit in result.fits]
    for one, share in zip(space.unknowns, result.best.z, strict=True):
        around = [fit[one.name] for fit in others]
        prior = f"{one.prior:g} " + (f"x/ {math.exp(one.spread):.2g}" if one.log else f"+- {one.spread:g}")
        bounds, note = f"{one.low:g} .. {one.high:g}", "at a bound" if min(share, 1.0 - share) < AT_BOUND else ""
        table.add_row(
            one.name,
            f"{values[one.name]:g}",
            f"{min(around):g} .. {max(around):g}",
            prior,
            bounds,
            f"[yellow]{note}[/]",
        )
    return table


def margins_table(result: Result) -> Table:
    """What each trial of stability left."""
    numbers = ("swing left [mm]", "growth")
    table = empty("Margins", ("trial", *numbers, "kept"), numbers)
    for one in result.best.margins:
        trial = f"{one.trial.actuator} {one.trial.reference} {one.trial.change}"
        table.add_row(trial, f"{1e3 * one.swing:.2f}", f"{one.growth:.2f}", "yes" if one.kept else "[red]no[/]")
    return table


def spread_table(result: Result) -> Table:
    """The interval of every row."""
    heads = ("paper", "fit", "5 %", "median", "95 %", "numbers")
    table = empty("The paper's rows over the near-equal fits", ("row", "role", *heads, "inside"), heads)
    for one in result.spread:
        numbers = (f"{number:.2f}" for number in (one.best, one.low, one.median, one.high))
        inside = "yes" if one.inside else "[red]no[/]"
        table.add_row(" ".join(one.row.key), one.row.role, f"{one.row.paper}", *numbers, str(one.numbers), inside)
    return table
