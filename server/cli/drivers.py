"""Drivers of hardware: which there are, and whether one keeps to what is asked of it."""

import json
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape

from server.cli.tables import empty
from server.cli.typed import commands, refuse_given

app = commands(no_args_is_help=True, help=__doc__)
out = Console()

MARKS = {True: "[green]yes[/]", False: "[red]no[/]", None: "[yellow]-[/]"}


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
) -> None:
    """Try a driver the hard way, against its virtual peer or your own device."""
    from controller.drivers.conformance import Row, check_driver
    from controller.virtual.registry import has_peer

    given = dict(parsed(option) for option in options or [])
    rows: list[Row] = []
    if peer or (peer is None and not given and has_peer(name)):
        from controller.virtual.bench import PeerBench

        if not has_peer(name):
            raise typer.BadParameter(f"driver {name} has no virtual peer: `tendril drivers list`", param_hint="--peer")
        refuse_given(context, "is for your own device, and this is the virtual peer; say --no-peer", "drive")
        bench = PeerBench(name)
        try:
            rows = check_driver(name, given, bench, tell=_tell)
        finally:
            bench.close()
    else:
        rows = check_driver(name, given, drive=drive, tell=_tell)
    table = empty(f"driver {escape(name)}", ["passed", "check"], [])
    table.add_column("detail")
    for row in rows:
        table.add_row(MARKS[row.passed], row.check, escape(row.detail))
    out.print(table)
    raise typer.Exit(0 if all(row.passed is not False for row in rows) else 1)


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
