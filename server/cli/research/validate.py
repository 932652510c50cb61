"""`tendril validate` at the command line: leave-one-out figures of every stiffness profile."""

from pathlib import Path
from typing import NamedTuple

from rich.console import Console

from controller.research.identification.motion.decays import long_ones, read_decays
from controller.research.identification.observe import starts
from controller.research.identification.score import ScoringTask
from controller.research.identification.validate import trials, validate
from controller.schema.actuator import Actuator, by_joints
from controller.schema.origin import hashes, origin
from controller.system.origin import command_line
from controller.system.progress import progress
from server.cli.files import require_file, write_json
from server.cli.research.observe import scores_table


class ValidationTask(NamedTuple):
    """What a user asks for; bodies count from 1, as in the file's header."""

    data: Path
    base: Actuator
    sense: tuple[int, ...]
    score: tuple[int, ...]
    ids: str | None
    from_s: float
    rate: float | None
    """Of the observer's springs [rad/s]."""
    every: bool
    """Every stiffness profile, not only what is identified."""


def run_validate(request: ValidationTask, json_file: Path | None, console: Console) -> None:
    """Validate, show, and write what is asked for; TendrilError says what is wrong."""
    if json_file is not None:
        require_file(json_file)
    decays = long_ones(read_decays(request.data, request.ids), "leave out", request.data)
    sensed, scored = (tuple(sorted({body - 1 for body in some})) for some in (request.sense, request.score))
    task = ScoringTask(sensed, scored, starts(request.from_s))
    with progress(console, "Leaving decays out") as told:
        found = validate(decays, by_joints(request.base), task, trials(request.rate, every=request.every), told)
    for one in found:
        console.print(scores_table(f"Stiffness {one['form']}", one["bodies"]))
    if json_file is not None:
        about = {"actuators": (request.base,), "files": hashes([request.data])}
        figures = {"forms": found, "decays": [one.id for one in decays], "sensed": [body + 1 for body in sensed]}
        write_json(json_file, figures, origin(command_line(), **about))
        console.print(f"Written: {json_file}", markup=False, soft_wrap=True, highlight=False)
