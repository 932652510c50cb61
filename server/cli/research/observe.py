"""`tendril observe` at the command line: the offline observer's figures beside those that need no model."""

from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from controller.errors import ParameterError
from controller.research.identification.observe import ObserverTask, Scores, observe_decays
from controller.research.identification.score import Score
from controller.schema.origin import hashes, origin
from controller.system.origin import command_line
from controller.system.progress import progress
from server.cli.files import require_file, write_json


def run_observe(request: ObserverTask, json_file: Path | None, rrd: Path | None, console: Console) -> None:
    """Observe, show, and write what is asked for; TendrilError says what is wrong."""
    for path in filter(None, (json_file, rrd)):
        require_file(path)
    with progress(console, "Observing") as told:
        observed = observe_decays(request, told)
    show(observed.scores, console)
    if json_file is not None:
        about = {"actuators": (request.actuator,), "files": hashes([request.data])}
        write_json(json_file, observed.scores, origin(command_line(), **about))
    if rrd is not None:
        from server.cli.research.observed import write_observed

        write_observed(observed, rrd)
    for path in filter(None, (json_file, rrd)):
        console.print(f"Written: {path}", markup=False, soft_wrap=True, highlight=False)


def numbers(field: str, text: str) -> tuple[int, ...]:
    """Bodies from a list like 1,2; ParameterError names what is not a whole number."""
    try:
        return tuple(int(part) for part in text.split(","))
    except ValueError:
        raise ParameterError(f"{field} = {text!r} is not a list of whole numbers like 1,2") from None


def show(scores: Scores, console: Console) -> None:
    """Errors of every scored body, in mm and as a share of its motion."""
    sensed = ", ".join(map(str, scores["sensed"]))
    console.print(scores_table(f"Lateral errors with body {sensed} sensed", scores["bodies"]))
    console.print(f"{scores['samples']} samples", highlight=False)


def scores_table(title: str, bodies: Sequence[Score]) -> Table:
    """One row for each body and window."""
    table = Table(title=title, title_justify="left", box=None, pad_edge=False)
    heads = ("body", "from [s]", "error [mm]", "motion [mm]", "observer", "curvature", "ratio", "mode", "own ratio")
    for head in heads:
        table.add_column(head, justify="right")
    for one in bodies:
        shares = (
            one["percent_of_motion"],
            one["constant_curvature_percent"],
            one["fixed_ratio_percent"],
            one["mode_shape_percent"],
            one["own_ratio_percent"],
        )
        table.add_row(
            str(one["body"]),
            f"{one['from_s']:g}",
            f"{one['rms_error_mm']:.2f}",
            f"{one['rms_motion_mm']:.2f}",
            *("-" if share is None else f"{share:.1f} %" for share in shares),
        )
    return table
