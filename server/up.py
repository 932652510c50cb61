"""`tendril up`: rig and server as two child processes on this machine, both kept alive, and one address printed."""

import logging
import os
import signal
import subprocess
import sys
import tempfile
import time
import webbrowser
from pathlib import Path
from typing import IO
from urllib.parse import urlsplit

from rich.console import Console
from rich.panel import Panel

from controller.errors import TendrilError
from controller.realtime.settings import RigSettings
from controller.realtime.supervisor import SHORT_LIFE, Supervisor, end_process, restart_delay
from server.presets.actuator import kept_actuator, kept_file, take_order
from server.ready import ServerReady, UpReady, write_ready
from server.settings import ServerSettings
from server.tls import require_certificate

log = logging.getLogger(__name__)
out = Console()

POLL = 0.05
START_TIMEOUT = 60.0
STOP_TIMEOUT = 20.0
"""The server lets the rig vent first [s]."""


class ServerChild:
    """The server as a child process, started again when it dies."""

    def __init__(
        self,
        settings: ServerSettings,
        ready: Path,
        program: tuple[str, ...] = ("server",),
        output: IO[bytes] | None = None,
    ) -> None:
        """`program` follows `python -m`; `output` None leaves it where ours goes."""
        self._command, self._output = [sys.executable, "-m", *program, str(ready)], output
        self._environment = os.environ | environment(settings)
        self._ready = ready
        self._deaths = 0
        self._due = 0.0
        self._born = 0.0
        self.process = self._start()

    def wait_ready(self) -> ServerReady:
        """Wait for the first answer; raises `TendrilError` if the server dies before."""
        for _ in range(int(START_TIMEOUT / POLL)):
            if self._ready.exists():
                found = ServerReady.model_validate_json(self._ready.read_bytes())
                self._environment["TENDRIL_PORT"] = str(urlsplit(found.url).port)  # the page finds a restarted server
                return found
            if self.process.poll() is not None:
                raise TendrilError("the server could not start; its own output says why")
            time.sleep(POLL)
        raise TendrilError(f"the server is not ready after {START_TIMEOUT:.0f} s")

    def keep_alive(self) -> None:
        """Start it again if it is dead: at once the first time, with growing delay when it keeps dying young."""
        if self.process.poll() is None:
            return
        if not self._due:
            fields = {"code": self.process.poll()}
            log.error("server ended with code %s: restart", *fields.values(), extra=fields)
            self._deaths = self._deaths + 1 if time.monotonic() - self._born < SHORT_LIFE else 0
            self._due = time.monotonic() + restart_delay(self._deaths)
        if time.monotonic() >= self._due:
            self.process = self._start()

    def stop(self) -> None:
        """End it with SIGTERM, after a while with SIGKILL."""
        end_process(self.process, STOP_TIMEOUT)

    def _start(self) -> subprocess.Popen[bytes]:
        self._ready.unlink(missing_ok=True)
        self._born, self._due = time.monotonic(), 0.0
        # A session of its own: Ctrl-C in the terminal is for us, we end both children in order.
        return subprocess.Popen(
            self._command, env=self._environment, stdout=self._output, stderr=self._output, start_new_session=True
        )


def run_up(rig: RigSettings, server: ServerSettings, browser: bool, ready: Path | None) -> None:
    """Run rig and server until SIGINT or SIGTERM; the server ends first, so the rig comes to rest before it ends."""
    require_certificate(server)
    for number in (signal.SIGINT, signal.SIGTERM):  # a shell may have started us in the background, SIGINT ignored
        signal.signal(number, signal.default_int_handler)
    out.quiet = server.log_format == "json"
    supervisor = Supervisor(rig)
    supervisor.start()
    try:
        with out.status("Starting the rig (kernels are compiled once per version, about a minute) ..."):
            supervisor.wait_ready()
        _run_server(supervisor, server.model_copy(update={"endpoint": supervisor.endpoint}), browser, ready)
    except KeyboardInterrupt:
        out.print("Stopping ...")
    finally:
        supervisor.stop()


def with_last_actuator(rig: RigSettings, server: ServerSettings) -> RigSettings:
    """`rig` with the actuator that was chosen last in the page; as it is, with a warning, where that cannot be had."""
    path, parameters = kept_file(server), rig.parameters
    try:
        actuator = kept_actuator(path, parameters)
    except TendrilError as error:
        log.warning("actuator %s, not the one chosen last: %s %s", parameters.actuator.name, path, error)
        return rig
    if actuator is None:
        return rig
    out.print(f"Actuator {actuator.name}, as chosen last in the page; --actuator takes another.", markup=False)
    return rig.model_copy(update={"parameters": parameters.model_copy(update={"actuator": actuator})})


def environment(settings: ServerSettings) -> dict[str, str]:
    """`settings` as environment variables: the tokens must not be seen in a list of processes."""
    secret = {"token": settings.token, "viewer_token": settings.viewer_token}
    plain = settings.model_dump(mode="json", exclude_none=True, exclude=set(secret))
    tokens = {name: value.get_secret_value() for name, value in secret.items() if value is not None}
    return {f"TENDRIL_{name.upper()}": str(value) for name, value in {**plain, **tokens}.items()}


def _run_server(supervisor: Supervisor, settings: ServerSettings, browser: bool, ready: Path | None) -> None:
    with tempfile.TemporaryDirectory(prefix="tendril-") as folder:
        orders = Path(folder, "actuator.json")
        child = ServerChild(settings.model_copy(update={"orders": orders}), Path(folder, "server.json"))
        try:
            page = child.wait_ready()
            _announce(page, browser)
            if ready:
                processes = {"rig_process": supervisor.process, "server_process": page.process}
                write_ready(ready, UpReady(url=page.url, viewer_url=page.viewer_url, **processes))
            while True:
                time.sleep(POLL)
                child.keep_alive()
                if (actuator := take_order(orders)) is not None:
                    parameters = supervisor.settings.parameters
                    supervisor.replace(parameters.model_copy(update={"actuator": actuator}))
        finally:
            child.stop()


def _announce(page: ServerReady, browser: bool) -> None:
    log.info("ready on %s", page.url.split("/?")[0])
    text = (
        f"To operate:         [bold]{page.url}[/]\n"
        f"To look (and stop): {page.viewer_url}\n\n"
        "Each address holds an access token (`tendril token`). Ctrl-C stops rig and server."
    )
    out.print(Panel(text, title="Tendril"))
    if browser and (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        webbrowser.open(page.url)
