"""The command `tendril`. Each command imports what it needs, so that a rig never loads the server's libraries."""

import json
import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer
from rich.console import Console
from rich.logging import RichHandler

from controller.errors import TendrilError
from controller.system.complaints import one_line_errors
from controller.system.logs import LogFormat, log_json
from server.cli.docs import docs
from server.cli.drivers import app as drivers_app
from server.cli.recordings import app as recordings_app
from server.cli.research.commands import ActuatorName, PlantName
from server.cli.research.commands import app as research_app
from server.cli.rig_files import virtual_rig
from server.cli.tokens import app as token_app
from server.cli.typed import (
    ObserverKappa,
    RecordingsFolder,
    TwinNumbers,
    commands,
    controller_of,
    refuse_given,
)

if TYPE_CHECKING:
    from controller.schema.actuator import Actuator
    from controller.schema.parameters import ControllerParameters, RigParameters, TwinParameters
    from server.app.ready import Addresses

app = commands(no_args_is_help=True, pretty_exceptions_enable=False)
app.add_typer(recordings_app, name="recordings")
app.add_typer(token_app, name="token")
app.add_typer(drivers_app, name="drivers")
app.command("virtual-rig")(virtual_rig)
app.add_typer(research_app)
out = Console()

RigName = Annotated[str, typer.Option(help="Rig id: part of every key on the link and of every recording.")]
RigOrFile = Annotated[
    str,
    typer.Option(help="Rig id, part of every key and recording; or a rig file (.toml), which drives real devices."),
]
Host = Annotated[str, typer.Option(help="Address to serve on; anything but loopback is reachable by others.")]
Port = Annotated[int, typer.Option(help="Port to serve on; 0 takes a free one.")]
KeyFile = Annotated[
    Path | None,
    typer.Option(envvar="TENDRIL_KEY_FILE", help="The rig's key; RIG.key in the state folder without it."),
]
LinkTls = Annotated[
    Path | None,
    typer.Option(envvar="TENDRIL_LINK_TLS", help="Folder of ca.pem, cert.pem and key.pem, for tls/ endpoints."),
]
Log = Annotated[
    LogFormat,
    typer.Option("--log-format", envvar="TENDRIL_LOG_FORMAT", help="json: one object a line, and no token in it."),
]
TlsCert = Annotated[
    Path | None, typer.Option(envvar="TENDRIL_TLS_CERT", help="Certificate (PEM): serve https, with --tls-key.")
]
TlsKey = Annotated[Path | None, typer.Option(envvar="TENDRIL_TLS_KEY", help="Its private key (PEM, no password).")]
AllowHost = Annotated[
    str,
    typer.Option(
        envvar="TENDRIL_ALLOW_HOST", help="Other names by which browsers may ask for this server; commas between them."
    ),
]
Ready = Annotated[Path | None, typer.Option(help="Write address and process ids to this file when ready.")]
UnitName = Literal["rig", "server"]
LastActuator = Annotated[
    str | None,
    typer.Option(help="P1, P2, P3 or a .toml file; without it the one chosen last in the page, P1 at first."),
]
Rods = Annotated[int, typer.Option(help="Rods of the observer's model, 2 to 1000.")]
Stepping = Annotated[
    Literal["rk4", "implicit"], typer.Option(help="The observer's step; rk4, the paper's, takes 10 rods or so.")
]

LoopGap = Annotated[
    float | None,
    typer.Option(help="The rig holds after its loop stood still for so long [s], 0.05 or what the rig file says."),
]
OperatorTimeout = Annotated[
    float | None,
    typer.Option(help="It holds after its operator gave no sign for so long [s], 0.5 or what the rig file says."),
]


def _say_version(wanted: bool) -> None:
    from controller.system.origin import version_text

    if wanted:
        typer.echo(version_text())
        raise typer.Exit


@app.callback()
def configure(
    verbose: Annotated[bool, typer.Option("--verbose", "-v", help="Log more.")] = False,
    version: Annotated[
        bool, typer.Option("--version", callback=_say_version, is_eager=True, help="Print version and commit.")
    ] = False,
) -> None:
    """Live dashboard and teleoperation for planar pneumatic soft actuators."""
    logging.basicConfig(
        level=logging.INFO if verbose else logging.WARNING, format="%(message)s", handlers=[RichHandler(console=out)]
    )


@app.command()
def up(
    context: typer.Context,
    rig: RigOrFile = "twin",
    actuator: LastActuator = None,
    plant: PlantName = "rod",
    rods: Rods = 10,
    integrator: Stepping = "implicit",
    observer_kappa: ObserverKappa = None,
    twin: TwinNumbers = "",
    loop_gap: LoopGap = None,
    operator_timeout: OperatorTimeout = None,
    host: Host = "127.0.0.1",
    port: Port = 8321,
    recordings: RecordingsFolder = None,
    key_file: KeyFile = None,
    tls_cert: TlsCert = None,
    tls_key: TlsKey = None,
    allow_host: AllowHost = "",
    browser: Annotated[bool, typer.Option(help="Open the page if there is a display.")] = True,
    ready: Ready = None,
    log_format: Log = "text",
) -> None:
    """Start rig (twin, or the devices of a rig file) and server on this machine and keep both alive."""
    from controller.realtime.settings import RigSettings
    from controller.schema.actuator import read_actuator
    from controller.schema.twin_numbers import twin_numbers
    from server.app.up import run_up, with_last_actuator
    from server.cli.rig_files import named_rig, rig_parameters
    from server.settings import ServerSettings

    _start_log("up", log_format)
    name, file = named_rig(rig)
    _refuse_beside_file(context, file)
    patience = _given(loop_gap=loop_gap, operator_timeout=operator_timeout)
    settings = ServerSettings(
        rig=name,
        rig_file=file,
        host=host,
        port=port,
        recordings=recordings,
        key_file=key_file,
        tls_cert=tls_cert,
        tls_key=tls_key,
        allow_host=allow_host,
        log_format=log_format,
    )

    def parameters() -> "tuple[RigParameters, RigParameters | None]":
        if file is not None:
            return rig_parameters(file, patience), None
        body = read_actuator(actuator or "P1")
        found = _parameters(
            body, twin_numbers(twin, plant=plant), controller_of(body, observer_kappa, rods, integrator), patience
        )
        return (found, None) if actuator else (with_last_actuator(found, settings, observer_kappa), found)

    run_up(RigSettings(rig=name, log_format=log_format), parameters, settings, browser, ready)


@app.command()
def serve(
    context: typer.Context,
    rig: RigName = "twin",
    endpoint: Annotated[str, typer.Option(help="Where the rig listens.")] = "tcp/127.0.0.1:7447",
    host: Host = "127.0.0.1",
    port: Port = 8321,
    recordings: RecordingsFolder = None,
    key_file: KeyFile = None,
    link_tls: LinkTls = None,
    tls_cert: TlsCert = None,
    tls_key: TlsKey = None,
    allow_host: AllowHost = "",
    ready: Ready = None,
    log_format: Log = "text",
) -> None:
    """Start the server only; the rig may run on another machine."""
    from server.app.ready import announce_to
    from server.app.run import run_server
    from server.settings import ServerSettings

    _start_log("server", log_format)
    _refuse_certificates(context, "--endpoint", endpoint)
    settings = ServerSettings(
        rig=rig,
        endpoint=endpoint,
        log_format=log_format,
        key_file=key_file,
        link_tls=link_tls,
        host=host,
        port=port,
        recordings=recordings,
        tls_cert=tls_cert,
        tls_key=tls_key,
        allow_host=allow_host,
    )
    say = (lambda at: None) if log_format == "json" else _say_addresses  # a log goes where others read
    run_server(settings, announce_to(ready) if ready else say)


@app.command()
def rig(
    context: typer.Context,
    rig: RigOrFile = "twin",
    actuator: ActuatorName = "P1",
    plant: PlantName = "rod",
    rods: Rods = 10,
    integrator: Stepping = "implicit",
    observer_kappa: ObserverKappa = None,
    twin: TwinNumbers = "",
    loop_gap: LoopGap = None,
    operator_timeout: OperatorTimeout = None,
    listen: Annotated[str, typer.Option(help="Where servers connect.")] = "tcp/127.0.0.1:7447",
    key_file: KeyFile = None,
    link_tls: LinkTls = None,
    ready: Ready = None,
    log_format: Log = "text",
) -> None:
    """Start the rig process only: the 1 kHz loop, with the twin or the devices of a rig file."""
    from controller.realtime.rig import run_rig
    from controller.realtime.settings import RigSettings
    from controller.schema.actuator import read_actuator
    from controller.schema.twin_numbers import twin_numbers
    from server.cli.rig_files import named_rig, rig_parameters

    _start_log("rig", log_format)
    _refuse_certificates(context, "--listen", listen)
    name, file = named_rig(rig)
    _refuse_beside_file(context, file)
    patience = _given(loop_gap=loop_gap, operator_timeout=operator_timeout)
    if file is None:
        body = read_actuator(actuator)
        numbers, observer = twin_numbers(twin, plant=plant), controller_of(body, observer_kappa, rods, integrator)
        parameters = _parameters(body, numbers, observer, patience)
    else:
        parameters = rig_parameters(file, patience)
    link = RigSettings(rig=name, listen=listen, key_file=key_file, link_tls=link_tls, ready=ready)
    run_rig(link.model_copy(update={"parameters": parameters}))


@app.command()
def bench(
    json_file: Annotated[Path | None, typer.Option("--json", help="Write the figures to this file.")] = None,
    quick: Annotated[bool, typer.Option(help="A live loop of 5 s instead of 60 s, and fewer rounds.")] = False,
) -> None:
    """Measure rod step, controller tick and the live loop on this machine."""
    from controller.schema.origin import origin_of_rig
    from controller.schema.parameters import RigParameters
    from controller.system.origin import command_line
    from server.cli.bench import run_bench
    from server.cli.files import require_file, write_json

    if json_file is not None:
        require_file(json_file)
    figures = run_bench(quick, out)
    if json_file is not None:
        write_json(json_file, figures, origin_of_rig(RigParameters(), command_line()))


@app.command()
def faults(
    json_file: Annotated[Path | None, typer.Option("--json", help="Write the verdicts to this file.")] = None,
    only: Annotated[
        str | None, typer.Option(help="Names of faults as in `tendril docs faults`, with commas between.")
    ] = None,
    quick: Annotated[bool, typer.Option(help="A handful of them, within a minute.")] = False,
    repeat: Annotated[int, typer.Option(min=1, max=100, help="Run the campaign so often.")] = 1,
) -> None:
    """Break a rig (twin), its server and their surroundings in every known way, and judge what they do."""
    from controller.schema.origin import origin_of_rig
    from controller.schema.parameters import RigParameters
    from controller.system.origin import command_line
    from server.campaign.campaign import run_campaign
    from server.campaign.table import chosen
    from server.cli.files import require_file, write_json

    if json_file is not None:
        require_file(json_file)
    verdicts = run_campaign(chosen(only, quick), repeat, out)
    if json_file is not None:
        write_json(json_file, {"faults": verdicts}, origin_of_rig(RigParameters(), command_line()))
    raise typer.Exit(0 if all(verdict["pass"] for verdict in verdicts) else 1)


@app.command()
def compile() -> None:
    """Compile every kernel into the cache, so that the first start is quick."""
    from server.cli.kernels import compile_kernels

    compile_kernels(out)


@app.command()
def systemd(unit: Annotated[UnitName, typer.Argument(help="The process to run as a service.")]) -> None:
    """Print a systemd unit for this installation (`tendril docs operation`)."""
    from server.app.systemd import unit_text

    sys.stdout.write(unit_text(unit))


@app.command()
def schema() -> None:
    """Print the server's OpenAPI, socket messages included: the page's types are made from it."""
    from server.app.app import openapi_schema

    sys.stdout.write(json.dumps(openapi_schema(), indent=1) + "\n")


app.command()(docs)


def main() -> None:
    """Entry point: our own errors are one clear line, not a traceback."""
    with one_line_errors(), _extras_named():
        app(prog_name="tendril")


@contextmanager
def _extras_named() -> Iterator[None]:
    """Only research needs these libraries: a command that lacks one says what to install."""
    try:
        yield
    except ModuleNotFoundError as error:
        lacking = (error.name or "").partition(".")[0]
        if lacking not in ("cma", "h5py", "matplotlib"):
            raise
        from controller.system.origin import install_command

        raise TendrilError(f"this command needs {lacking}: {install_command('research')}") from error


def _refuse_beside_file(context: typer.Context, file: Path | None) -> None:
    """What a twin is made of comes from options, and a real rig from its file alone."""
    if file is not None:
        why = f"{file} says which actuator is driven, and by which model; change it there"
        refuse_given(context, why, "actuator", "plant", "rods", "integrator", "observer_kappa", "twin")


def _given(**limits: float | None) -> dict[str, float]:
    """Those that the command names."""
    return {name: value for name, value in limits.items() if value is not None}


def _refuse_certificates(context: typer.Context, option: str, endpoint: str) -> None:
    """They would protect nothing, and who gives them believes that they do."""
    if not endpoint.startswith("tls/"):
        refuse_given(context, f"is for an endpoint tls/..., and {option} is {endpoint}", "link_tls")


def _start_log(process: str, log_format: LogFormat) -> None:
    if log_format == "json":
        log_json(process)


def _say_addresses(at: "Addresses") -> None:
    out.print(f"to operate: {at.operator}\nto look:    {at.viewer}", markup=False, soft_wrap=True)


def _parameters(
    actuator: "Actuator", twin: "TwinParameters", controller: "ControllerParameters", patience: dict[str, float]
) -> "RigParameters":
    """Those of a rig, refused here rather than in the process that would run it."""
    from controller.schema.actuator import PRESETS
    from controller.schema.parameters import RigParameters, SafetyLimits
    from controller.simulation.acceptance import require_built, require_running

    limits = SafetyLimits.model_validate(patience)
    parameters = RigParameters(actuator=actuator, controller=controller, limits=limits, twin=twin)
    require = require_built if actuator in PRESETS.values() else require_running
    require(parameters)
    return parameters
