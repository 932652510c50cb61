"""The listening socket of a server, and where a browser finds it."""

import socket

from controller.errors import TendrilError
from server.settings import ServerSettings

UNSENT_MAX = 16 * 1024
"""Bytes that may wait in the kernel for a slow viewer: beyond it, frames are skipped instead of delayed."""

AT_ONCE = 8
"""Connections that one turn of the network's loop accepts. libuv takes one for each handle, and under a flood a turn
lasts for milliseconds: an E-STOP on a new connection waited for a second behind those of the flood.
"""


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


def handles(listening: socket.socket) -> list[socket.socket]:
    """`AT_ONCE` handles of the one socket, itself the first."""
    return [listening, *(listening.dup() for _ in range(AT_ONCE - 1))]


def address(settings: ServerSettings, listening: socket.socket) -> str:
    """Where a browser on this machine finds the server."""
    host = settings.host
    shown = {"0.0.0.0": "127.0.0.1", "::": "[::1]", "::1": "[::1]"}.get(host, host)
    return f"{'https' if settings.tls_cert else 'http'}://{shown}:{listening.getsockname()[1]}"
