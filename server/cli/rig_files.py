"""Rigs of real devices: what a rig file makes of the commands, and the virtual rig that stands in for its devices."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from controller.schema.parameters import RigParameters

SUFFIX = ".toml"


def named_rig(given: str) -> tuple[str, Path | None]:
    """Rig id and rig file of what was given as `--rig`: a name, or a file."""
    from controller.schema.rig_file import read_rig_file

    if not given.endswith(SUFFIX):
        return given, None
    path = Path(given).absolute()
    return read_rig_file(path).name, path


def rig_parameters(path: Path, limits: dict[str, float]) -> "RigParameters":
    """Those of the rig in this file, refused here, by its name, rather than in the process that would run it.

    `limits` stand in place of its own.
    """
    from controller.errors import ParameterError
    from controller.schema.parameters import SafetyLimits
    from controller.schema.rig_file import read_rig_file
    from controller.simulation.acceptance import accepted_rig

    found = read_rig_file(path)
    found = found.model_copy(update={"limits": SafetyLimits.model_validate(found.limits.model_dump() | limits)})
    try:
        return accepted_rig(found, path.parent)
    except ParameterError as error:
        raise ParameterError(f"{path}: {error}") from error


def virtual_rig(
    rig_file: Annotated[Path, typer.Argument(help="The rig file whose devices are stood in for.")],
    plant: Annotated[str, typer.Option(help="Simulated plant: rod or cosserat.")] = "",
    out: Annotated[
        Path | None,
        typer.Option(help="Write a rig file with the addresses that were taken, where the given one leaves them open."),
    ] = None,
) -> None:
    """Simulate a rig in a process of its own that speaks the wires of real devices (tendril docs hardware)."""
    from controller.realtime.priority import prefer_process
    from controller.virtual.rig import run_virtual_rig

    prefer_process()  # no real device waits for a browser
    run_virtual_rig(rig_file, plant, out)
