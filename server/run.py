"""Run the server: the listening socket, uvicorn, and everything it serves, until SIGTERM or SIGINT."""

import logging
import socket
import sys
from collections.abc import Callable

import uvicorn
from fastapi import FastAPI

from controller.errors import TendrilError
from server.app import create_app
from server.connections import Connection, Socket
from server.services import open_services
from server.settings import ServerSettings, exposed

log = logging.getLogger(__name__)

SWITCH_INTERVAL = 5e-4
"""Longest time [s] for which one Python thread keeps another waiting (Python's own choice is 5 ms)."""
UNSENT_MAX = 16 * 1024
"""Bytes that may wait in the kernel for a slow viewer: beyond it, frames are skipped instead of delayed."""
MESSAGE_MAX = 1 << 20
"""Longest message that a browser may send on a socket [bytes]."""


def run_server(settings: ServerSettings, ready: Callable[[str], None] = print) -> None:
    """Serve until stopped; `ready` gets the address with the access token once connections are accepted."""
    sys.setswitchinterval(SWITCH_INTERVAL)
    if exposed(settings.host):
        log.warning(
            "listening on %s: everyone in that network can reach this server, and the token travels unencrypted; "
            "prefer an SSH tunnel or a TLS proxy",
            settings.host,
        )
    listening = listen(settings.host, settings.port)
    services = open_services(settings)
    ready(f"{address(settings.host, listening)}/?token={services.secrets.token}")
    uvicorn_server(create_app(services)).run(sockets=[listening])


def uvicorn_server(app: FastAPI) -> uvicorn.Server:
    """One worker; no compression on sockets, which would cost more than the bytes it saves."""
    config = uvicorn.Config(
        app,
        http=Connection,
        ws=Socket,
        ws_max_size=MESSAGE_MAX,
        ws_per_message_deflate=False,
        log_level="warning",
        access_log=False,
        server_header=False,
        proxy_headers=False,
        timeout_graceful_shutdown=2,
    )
    return uvicorn.Server(config)


def listen(host: str, port: int) -> socket.socket:
    """A listening TCP socket; port 0 takes a free one."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listening = socket.socket(family, socket.SOCK_STREAM)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    if hasattr(socket, "TCP_NOTSENT_LOWAT"):
        listening.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, UNSENT_MAX)
    try:
        listening.bind((host, port))
    except OSError as error:
        listening.close()
        raise TendrilError(f"cannot serve on {host}, port = {port}: {error.strerror}; choose another --port") from error
    listening.listen(128)
    return listening


def address(host: str, listening: socket.socket) -> str:
    """Where a browser on this machine finds the server."""
    shown = {"0.0.0.0": "127.0.0.1", "::": "[::1]", "::1": "[::1]"}.get(host, host)
    return f"http://{shown}:{listening.getsockname()[1]}"
