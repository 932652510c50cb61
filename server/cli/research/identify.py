"""`tendril identify` at the command line: what was found, as a table, and where it was written."""

from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from controller.errors import ParameterError
from controller.reference.library import names, reference
from controller.research.identification.fit import Fit
from controller.research.identification.identify import IdentificationTask, identify, save
from controller.research.identification.report.report import number_text
from controller.schema.actuator import Actuator
from controller.schema.origin import origin
from controller.system.progress import progress
from server.cli.files import require_file, write_json


def run_identify(
    task: IdentificationTask, out: Path, report: Path | None, json_file: Path | None, console: Console
) -> None:
    """Fit, write and show; TendrilError says what is wrong with data, base or files."""
    if json_file is not None:
        require_file(json_file)
    with progress(console, "Fitting"):  # when a solver will have settled no one can say
        *before, last = identify(task)
        fits = [*before, replace(last, notes=(*last.notes, *reach_note(last.actuator, task.base)))]
        save(task, fits, out, report)
    for fit in fits:
        show(fit, console)
    if json_file is not None:
        made = origin(task.command, actuators=(task.base,))
        write_json(
            json_file, {"fits": [figures(fit) for fit in fits], "actuator": fits[-1].actuator.model_dump()}, made
        )
    for path in filter(None, (out, report, json_file)):
        console.print(f"Written: {path}", markup=False, soft_wrap=True, highlight=False)


def reach_note(found: Actuator, base: Actuator) -> tuple[str, ...]:
    """Which references of the library `base` could follow and `found` cannot, and by how much; () for none."""
    lost: dict[str, list[str]] = {}
    for name in names():
        if (why := _beyond(name, found)) and not _beyond(name, base):
            lost.setdefault(why, []).append(name)
    if not lost:
        return ()
    said = "; ".join(f"{', '.join(shapes)}: {why}" for why, shapes in lost.items())
    return (f"at u_max = {1e3 * found.u_max:.3g} mN m shapes of the library no longer fit: {said}",)


def _beyond(name: str, actuator: Actuator) -> str:
    """Why the actuator cannot follow it; "" if it can."""
    try:
        reference(name, actuator)
    except ParameterError as error:
        return "out of reach from the first point on" if str(error).startswith("p[0]") else str(error)
    return ""


def figures(fit: Fit) -> dict[str, object]:
    """What was found, without what is drawn; numbers in the units that stand beside them."""
    return {name: value for name, value in asdict(fit).items() if name not in ("plots", "actuator")}


def show(fit: Fit, console: Console) -> None:
    """Parameters with intervals, residuals and notes of one fit."""
    table = Table(title=escape(fit.title), title_justify="left", box=None, pad_edge=False)
    for column in ("parameter", "value", "95 % confidence", "unit"):
        table.add_column(column, justify="right" if column == "value" else "left")
    for row in _rows(fit):
        table.add_row(*map(escape, row))
    console.print(table)
    for note in fit.notes:
        console.print(f"[yellow]Note[/]: {escape(note)}", soft_wrap=True, highlight=False)


def _rows(fit: Fit) -> Sequence[tuple[str, ...]]:
    rows = []
    for one in fit.parameters:
        half = (one.high - one.low) / 2
        interval = f"{number_text(one.low, half)} .. {number_text(one.high, half)}" if half > 0 else ""
        rows.append((one.name, number_text(one.value, half), interval, one.unit))
    for misfit in fit.misfits:
        rows.append((f"residual, {misfit.name}", f"{misfit.rms:.3g}", f"rms of {misfit.samples}", misfit.unit))
    return rows
