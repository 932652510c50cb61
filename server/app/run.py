"""Run the server: the listening socket, uvicorn, and everything it serves, until SIGTERM or SIGINT."""

import logging
import resource
import sys
from collections.abc import Callable, Coroutine
from typing import Any

import uvicorn
from starlette.types import ASGIApp

from controller.system.logs import log_in_background
from controller.system.loop_watchdog import end_process
from controller.system.memory import collect_seldom, few_arenas, forget_start
from server.access.gate import COMMAND
from server.app.app import create_app
from server.app.application_loop import ApplicationLoop
from server.app.listening import address, handles, listen
from server.app.ready import Addresses
from server.app.services import Services
from server.app.shutdown import Server, come_to_rest
from server.http.connections import Doorstep, Socket
from server.http.tls import require_certificate
from server.settings import ServerSettings

log = logging.getLogger(__name__)

SWITCH_INTERVAL = 5e-4
"""Longest time [s] for which one Python thread keeps another waiting (Python's own choice is 5 ms)."""
FILES = 8192
"""Files and sockets that may be open; a page with a 3D view takes seven, and 1024 is what most systems begin with."""
KEPT_OPEN = 20.0
"""Idle connections are closed after this [s]: well after clients give them up, most of which do after 5 s. One that was
closed just as it is used again is an error in theirs."""
MESSAGE_MAX = 1 << 20
"""Longest message that a browser may send on a socket [bytes]."""


def run_server(settings: ServerSettings, ready: Callable[[Addresses], None]) -> None:
    """Serve until stopped; `ready` gets the addresses with the access tokens once connections are accepted."""
    log_in_background()
    sys.setswitchinterval(SWITCH_INTERVAL)
    _allow_files()
    few_arenas()
    collect_seldom()
    require_certificate(settings)
    if settings.unprotected:
        log.warning(
            "NOT ENCRYPTED: listening on %s without TLS: everyone in that network can reach this server, and can read "
            "and change what browsers say to it, tokens included. Give --tls-cert and --tls-key, or use an SSH tunnel",
            settings.host,
        )
    listening = listen(settings.host, settings.port)
    settings = settings.model_copy(update={"port": listening.getsockname()[1]})
    services = Services(settings, end_process)
    services.history.claim()
    url = address(settings, listening)
    log.info("serving on %s", url, extra={"url": url})
    at = Addresses(
        operator=f"{url}/?token={services.secrets.token}", viewer=f"{url}/?token={services.secrets.viewer_token}"
    )
    app = create_app(services)
    server = uvicorn_server(app, settings, lambda: come_to_rest(services), lambda: ready(at), end_process)
    forget_start()  # before anybody is served: it holds up whatever runs
    server.run(sockets=handles(listening))


def _allow_files() -> None:
    """Raise the limit of open files, as far as this process may."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = FILES if hard == resource.RLIM_INFINITY else min(FILES, hard)
    if soft != resource.RLIM_INFINITY and soft < wanted:
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))


def uvicorn_server(
    app: ASGIApp,
    settings: ServerSettings,
    before_end: Callable[[], Coroutine[Any, Any, None]],
    ready: Callable[[], None],
    deadly: Callable[[], None] | None = None,
) -> Server:
    """One worker; no compression on sockets, which would cost more than the bytes it saves. Commands, E-STOPs among
    them, are answered beside the application. `deadly` is called where the network's loop does not turn any more.
    """
    application = ApplicationLoop(app, frozenset({COMMAND}), uvicorn.Config(app).get_loop_factory())
    config = uvicorn.Config(
        application,
        http=Doorstep,
        ws=Socket,
        ws_max_size=MESSAGE_MAX,
        ws_per_message_deflate=False,
        log_config=None,
        log_level="warning",
        access_log=False,
        server_header=False,
        proxy_headers=False,
        timeout_keep_alive=KEPT_OPEN,  # type: ignore[arg-type]  # it takes any number
        timeout_graceful_shutdown=2,
        ssl_certfile=settings.tls_cert,
        ssl_keyfile=settings.tls_key,
    )
    return Server(config, application, before_end, ready, deadly)
