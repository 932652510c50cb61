"""Drivers of hardware: which there are, and whether one keeps to what is asked of it."""

import json
from importlib import import_module
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape

from server.cli.tables import empty
from server.cli.typed import commands, refuse_given

if TYPE_CHECKING:
    from controller.drivers.conformance import Recorder, Row
    from controller.virtual.bench import PeerBench

app = commands(no_args_is_help=True, help=__doc__)
out = Console()

COLOURS = {"shown": "green", "not shown": "yellow", "failed": "red"}
FAILED, NOT_SHOWN = 1, 3
"""Exit codes; 2 is for what was typed wrong."""


@app.command("list")
def list_drivers() -> None:
    """List ours and those of installed packages."""
    from controller.drivers.device import CaptureDevice
    from controller.drivers.registry import driver_class, driver_names
    from controller.errors import ParameterError
    from controller.virtual.registry import has_peer

    table = empty("drivers", ["name", "for", "virtual peer", "from"], [])
    for name, place in sorted(driver_names().items()):
        try:
            role = "motion capture" if issubclass(driver_class(name), CaptureDevice) else "valves"
        except ParameterError as error:
            role = str(error).rpartition("; ")[2] or str(error)
        table.add_row(name, escape(role), "yes" if has_peer(name) else "no", escape(place))
    out.print(table)


@app.command()
def check(
    context: typer.Context,
    name: Annotated[str, typer.Argument(help="As in `tendril drivers list`.")],
    options: Annotated[
        list[str] | None,
        typer.Option("--options", "-o", help="As in the rig file, NAME=VALUE; may be given several times."),
    ] = None,
    peer: Annotated[
        bool | None,
        typer.Option(help="Try it against its virtual peer; without this, if it has one and no options are given."),
    ] = None,
    drive: Annotated[
        bool, typer.Option("--drive", help="Command up to 40 kPa to a real board: no one may be near the actuator.")
    ] = False,
    record: Annotated[
        bool,
        typer.Option("--record", help="Stand between driver and device: keep what leaves, and pull the cable."),
    ] = False,
    decode: Annotated[
        str,
        typer.Option(help="MODULE:FUNCTION that says what recorded bytes tell the valves (docs drivers); as --record."),
    ] = "",
) -> None:
    """Try a driver the hard way, against its virtual peer or your own device.

    Ends with 0 if all was shown, 1 if a check failed, 3 if none failed and something was not shown.
    """
    from controller.drivers.conformance import check_driver
    from controller.virtual.registry import has_peer

    given = dict(parsed(option) for option in options or [])
    stands_in = peer or (peer is None and not given and not record and not decode and has_peer(name))
    if stands_in and not has_peer(name):
        raise typer.BadParameter(f"driver {name} has no virtual peer: `tendril drivers list`", param_hint="--peer")
    if stands_in:
        refuse_given(
            context, "is for your own device, and this is the virtual peer; say --no-peer", "drive", "record", "decode"
        )
    bench = _peer(name) if stands_in else _recorder(name, given, decode) if record or decode else None
    try:
        rows = check_driver(name, given, bench, drive, tell=_tell)
    finally:
        if bench is not None:
            bench.close()
    _print(name, rows)
    found = {row.answer for row in rows}
    raise typer.Exit(FAILED if "failed" in found else NOT_SHOWN if "not shown" in found else 0)


def _peer(name: str) -> "PeerBench":
    from controller.virtual.bench import PeerBench

    return PeerBench(name)


def _recorder(name: str, given: dict[str, Any], decode: str) -> "Recorder":
    from controller.drivers.conformance import Recorder
    from controller.drivers.registry import checked_options, driver_class

    whole = checked_options(driver_class(name), given, "driver").model_dump()
    return Recorder(whole, _function(decode) if decode else None)


def _function(place: str) -> Any:
    """The function at MODULE:FUNCTION; BadParameter where there is none."""
    module, _, name = place.partition(":")
    try:
        found = getattr(import_module(module), name)
    except (ImportError, AttributeError, ValueError) as error:
        raise typer.BadParameter(f"{place!r} is no MODULE:FUNCTION: {error}", param_hint="--decode") from error
    if not callable(found):
        raise typer.BadParameter(f"{place} is no function", param_hint="--decode")
    return found


def _print(name: str, rows: "list[Row]") -> None:
    table = empty(f"driver {escape(name)}", ["answer", "check"], [])
    table.add_column("detail")
    for row in rows:
        table.add_row(f"[{COLOURS[row.answer]}]{row.answer}[/]", row.check, escape(row.detail))
    out.print(table)
    answers: list[str] = [row.answer for row in rows]
    out.print(", ".join(f"{answers.count(answer)} {answer}" for answer in COLOURS), highlight=False)


def _tell(row: Any) -> None:
    if not out.is_terminal:
        return
    out.print(f"{row.check} ...", style="dim", highlight=False)


def parsed(option: str) -> tuple[str, Any]:
    """NAME=VALUE: numbers, true, false and lists as JSON has them, else text. BadParameter without "="."""
    name, separator, text = option.partition("=")
    if not separator or not name:
        raise typer.BadParameter(f"{option!r} is not NAME=VALUE", param_hint="--options")
    try:
        return name.strip(), json.loads(text)
    except ValueError:
        return name.strip(), text
