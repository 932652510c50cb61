"""`tendril up`: rig and server as two child processes on this machine, both kept alive, and one address printed."""

import html
import logging
import os
import signal
import stat
import subprocess
import sys
import tempfile
import time
import webbrowser
from collections.abc import Callable
from pathlib import Path
from typing import IO
from urllib.parse import urlsplit

from rich.console import Console
from rich.panel import Panel

from controller.errors import KeyRefused, StartRefused, TendrilError
from controller.realtime.only_one import only_one
from controller.realtime.settings import REFUSED, RigSettings, free_port
from controller.realtime.supervisor import Supervisor
from controller.schema.parameters import RigParameters
from controller.system.child import ChildProcess, launched
from controller.system.keys import made_key, mended_key
from controller.system.logs import log_in_background
from controller.system.scheduler import ErrorGuard
from controller.system.whole_file import write_whole
from server.app.listening import listen
from server.app.ready import ServerReady, UpReady, write_ready
from server.http.tls import require_certificate
from server.settings import ServerSettings

log = logging.getLogger(__name__)
out = Console()

OPENING = '<!doctype html><title>Tendril</title><meta http-equiv="refresh" content="0;url={url}">\n'
"""Leads a browser to the address with the token, which on its command line all users of the machine would see."""
POLL = 0.05
START_TIMEOUT = 300.0
"""A cold cache compiles for a minute, and both processes share the machine [s]."""
STOP_TIMEOUT = 20.0
"""The server lets the rig vent first [s]."""


class ServerChild:
    """The server as a child process, started again when it dies."""

    def __init__(
        self,
        settings: ServerSettings,
        ready: Path,
        program: tuple[str, ...] = ("server.app",),
        output: IO[bytes] | None = None,
    ) -> None:
        """`program` follows `python -m`; `output` None leaves it where ours goes."""
        self._program, self._output = (*program, str(ready)), output
        self._environment = environment(settings)
        self._ready = ready
        self.settings = settings
        self._child = ChildProcess("the server", self._launch)
        self._child.start()

    @property
    def process(self) -> int:
        """Process id of the present server, 0 if there is none."""
        return self._child.process.pid if self._child.process else 0

    def wait_ready(self) -> ServerReady:
        """Wait for the first answer; raises as `look`."""
        for _ in range(int(START_TIMEOUT / POLL)):
            if (found := self.look()) is not None:
                return found
            time.sleep(POLL)
        raise TendrilError(f"the server is not ready after {START_TIMEOUT:.0f} s")

    def look(self) -> ServerReady | None:
        """The first answer, None before it; TendrilError if the server died, StartRefused if it has said why."""
        if self._ready.exists():
            found = ServerReady.model_validate_json(self._ready.read_bytes())
            self._environment["TENDRIL_PORT"] = str(urlsplit(found.url).port)  # the page finds a restarted server
            return found
        if (code := self._child.look()) is not None:
            kind = StartRefused if code == REFUSED else TendrilError
            raise kind("the server could not start; its own output says why")
        return None

    def keep_alive(self) -> None:
        """Start it again if it is dead: at once the first time, with growing delay when it keeps dying young."""
        if (code := self._child.look()) is not None:
            log.error("server ended with code %s: restart", code, extra={"code": code})

    def stop(self) -> None:
        """End it with SIGTERM, after a while with SIGKILL."""
        self._child.stop(STOP_TIMEOUT)

    def _launch(self) -> "subprocess.Popen[bytes]":
        self._ready.unlink(missing_ok=True)
        return launched(self._program, self._output, self._environment)


def run_up(
    rig: RigSettings,
    parameters: Callable[[], tuple[RigParameters, RigParameters | None]],
    server: ServerSettings,
    browser: bool,
    ready: Path | None,
) -> None:
    """Run rig and server until SIGINT or SIGTERM; the server ends first, so the rig comes to rest before it ends.

    `parameters` are asked for once the server has been started: to check them takes as long as a start of the rig. A
    rig that does not come to tick with the first of them is started with the second.
    """
    log_in_background()
    require_certificate(server)
    for number in (signal.SIGINT, signal.SIGTERM):  # a shell may have started us in the background, SIGINT ignored
        signal.signal(number, signal.default_int_handler)
    out.quiet = server.log_format == "json"
    with only_one(rig), listen(server.host, server.port):
        pass  # what is in the way is said before anything starts, which takes seconds; rig and server have them then
    with tempfile.TemporaryDirectory(prefix="tendril-") as name:
        folder = Path(name)
        key, endpoint = usable_key(server, folder), free_port(rig.listen)
        shared = {"endpoint": endpoint, "key_file": key, "restarts": folder / "actuator.json"}
        child = ServerChild(server.model_copy(update=shared), folder / "server.json")
        opens = folder / "open.html" if browser else None
        try:
            _run_rig(rig.model_copy(update={"listen": endpoint, "key_file": key}), parameters, child, opens, ready)
        except KeyboardInterrupt:
            out.print("Stopping ...")
        finally:
            child.stop()


def usable_key(server: ServerSettings, folder: Path) -> Path:
    """File of the rig's key, there before rig and server read it: in `folder` where our own state takes no file."""
    if server.key_file is not None:
        made_key(server.key_file)
        return server.key_file
    try:
        mended_key(server.key)
    except KeyRefused as error:
        key = folder / server.key.name
        made_key(key)
        log.warning("the rig's key holds for this run alone: %s", error)
        return key
    return server.key


def with_last_actuator(
    parameters: RigParameters, server: ServerSettings, observer_kappa: float | None = None
) -> RigParameters:
    """`parameters` with the actuator that was chosen last in the page; as they are, with a warning, where it cannot be
    had. Their observer's kappa becomes what is usual with it, unless they were asked for with `observer_kappa`.
    """
    from controller.simulation.acceptance import require_built
    from server.hardware.actuator import kept_actuator, kept_file, with_other_actuator

    path = kept_file(server)
    try:
        actuator = kept_actuator(path)
        if actuator is None:
            return parameters
        wanted = with_other_actuator(parameters, actuator, observer_kappa)
        require_built(wanted)
    except TendrilError as error:
        log.warning("actuator %s, not the one chosen last: %s %s", parameters.actuator.name, path, error)
        return parameters
    out.print(f"Actuator {actuator.name}, as chosen last in the page; --actuator takes another.", markup=False)
    return wanted


def environment(settings: ServerSettings) -> dict[str, str]:
    """`settings` as environment variables: what is secret must not be seen in a list of processes."""
    secret = {"token": settings.token, "viewer_token": settings.viewer_token, "webhook": settings.webhook}
    plain = settings.model_dump(mode="json", exclude_none=True, exclude=set(secret))
    tokens = {name: value.get_secret_value() for name, value in secret.items() if value is not None}
    return {f"TENDRIL_{name.upper()}": str(value) for name, value in {**plain, **tokens}.items()}


def _run_rig(
    settings: RigSettings,
    parameters: Callable[[], tuple[RigParameters, RigParameters | None]],
    child: ServerChild,
    opens: Path | None,
    ready: Path | None,
) -> None:
    first, fallback = parameters()
    supervisor = Supervisor(settings.model_copy(update={"parameters": first}), fallback=fallback)
    supervisor.start()
    try:
        with out.status("Starting (kernels are compiled once per version, about a minute) ..."):
            page = _wait_for_both(supervisor, child)
        announce(page, opens)
        if ready:
            processes = {"rig_process": supervisor.process, "server_process": page.process}
            write_ready(ready, UpReady(url=page.url, viewer_url=page.viewer_url, **processes))
        _keep_alive(supervisor, child)
    finally:
        child.stop()
        supervisor.stop()


def _wait_for_both(supervisor: Supervisor, child: ServerChild) -> ServerReady:
    """What the server says once the rig is ready too; TendrilError if either dies before, or takes too long."""
    for _ in range(int(START_TIMEOUT / POLL)):
        page = child.look()
        if supervisor.is_ready(POLL) and page is not None:
            return page
        if page is None:
            time.sleep(POLL)
    late = "the server" if child.look() is None else f"rig {supervisor.settings.rig!r}"
    raise TendrilError(f"{late} is not ready after {2 * START_TIMEOUT:.0f} s")


def _keep_alive(supervisor: Supervisor, child: ServerChild) -> None:
    """Until we are told to end."""
    from server.hardware.actuator import kept_file
    from server.hardware.restarts import Restarts

    assert child.settings.restarts is not None
    carried_out = Restarts(child.settings.restarts, kept_file(child.settings), supervisor)
    guard = ErrorGuard()
    while True:
        time.sleep(POLL)
        guard.do("the server's life", child.keep_alive)
        guard.do("the supervisor", lambda: _require_sound(supervisor))
        guard.do("a restart that was asked for", carried_out.look)


def _require_sound(supervisor: Supervisor) -> None:
    if supervisor.worker.trouble:
        raise TendrilError(supervisor.worker.trouble)


def announce(page: ServerReady, opens: Path | None) -> None:
    """Print where the page is, with the access tokens where no one else reads it, and open it by way of `opens`."""
    bare = page.url.split("/?")[0]
    log.info("ready on %s", bare)
    text = (
        f"To operate:         [bold]{page.url}[/]\n"
        f"To look (and stop): {page.viewer_url}\n\n"
        "Each address holds an access token (`tendril token`). Ctrl-C stops rig and server."
    )
    if not seen_by_us_alone(sys.stdout.fileno()):
        text = (
            f"[bold]{bare}[/]\n\nOthers may read this, so it holds no access token: `tendril token show` prints them."
        )
    out.print(Panel(text, title="Tendril"))
    if opens is not None and (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        write_whole(opens, OPENING.format(url=html.escape(page.url)), lasting=False)
        webbrowser.open(opens.as_uri())


def seen_by_us_alone(output: int) -> bool:
    """Whether what is written to this file descriptor is for the user alone: a terminal, or a file of mode 0600.

    A pipe may end in a journal, or in a file that every user of the machine reads.
    """
    about = os.fstat(output)
    return os.isatty(output) or (stat.S_ISREG(about.st_mode) and not about.st_mode & 0o077)
