"""What all groups of commands have in common."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from controller.errors import ParameterError

if TYPE_CHECKING:
    from controller.schema.actuator import Actuator
    from controller.schema.parameters import ControllerParameters

RecordingsFolder = Annotated[
    Path | None,
    typer.Option(
        "--recordings",
        "--folder",
        envvar="TENDRIL_RECORDINGS",
        help="Folder of the recordings; the server's own without it.",
    ),
]

ObserverKappa = Annotated[
    float | None,
    typer.Option(
        help="Inertia of the actuator's table over the observer's, 1 to 100; without it that of the fit for P1 to P3, "
        "and 1 for others (docs observer)."
    ),
]

TwinNumbers = Annotated[
    str,
    typer.Option(
        "--twin",
        help="Numbers of the twin, as in a rig file: kappa=12,zeta=0.2,torque_gain=[1.1,1.0] (docs model). Without "
        "them P1 to P3 have those of the fit, another actuator what its file says.",
    ),
]

Comments = Annotated[bool, typer.Option("--comments", help="Begin a CSV file with its origin, as lines with #.")]


def controller_of(
    actuator: "Actuator", observer_kappa: float | None, rods: int = 10, integrator: str = "implicit"
) -> "ControllerParameters":
    """What options say of the observer of `actuator`; ParameterError with the bound."""
    from controller.schema.modes import Integrator
    from controller.schema.parameters import ControllerParameters, usual_kappa

    step = Integrator[integrator.upper()]
    kappa = usual_kappa(actuator, step) if observer_kappa is None else observer_kappa
    return ControllerParameters(rods=rods, integrator=step, observer_kappa=kappa)


def commands(**more: Any) -> typer.Typer:
    """A group of commands. Its help is Markdown, in which a unit in brackets stays as it is."""
    return typer.Typer(rich_markup_mode="markdown", **more)


def refuse_given(context: typer.Context, because: str, *names: str) -> None:
    """ParameterError for the first of the options `names` (of the command's function) that was typed: it would not be
    heard, `because` of another one. What the environment says is for all commands, and may be of no use in this one.
    """
    for parameter in context.command.params:
        source = context.get_parameter_source(parameter.name or "")
        if parameter.name in names and source is not None and source.name == "COMMANDLINE":
            value = context.params[parameter.name]
            shown = "" if isinstance(value, bool) else f" {value}"
            raise ParameterError(f"{parameter.opts[0]}{shown}: {because}")
