"""Why no session is opened: a look at an endpoint that does not let us in."""

import socket

from controller.errors import KeyRefused

PATIENCE = 0.5
"""For each step [s]."""
NONSENSE = b"\x01\x00" + b"\xff" * 62
"""No message of zenoh's, nor of TLS: either says so before it ends the connection."""


def kept_out(endpoint: str) -> KeyRefused | None:
    """What to say where something answers at `endpoint` (tcp/HOST:PORT or tls/...); None where nothing does.

    A rig that stands still or starts answers nothing, though its machine, or one on the way, may take the connection.
    """
    host, port = endpoint.partition("/")[2].rsplit(":", 1)
    try:
        with socket.create_connection((host.strip("[]"), int(port)), PATIENCE) as line:
            line.settimeout(PATIENCE)
            line.sendall(NONSENSE)
            if not line.recv(1):
                return None
    except (OSError, ValueError):
        return None
    certificate = ", a certificate is not trusted" if endpoint.startswith("tls/") else ""
    return KeyRefused(
        f"{endpoint} answers but opens no session: this server's key is not the rig's (copy the rig's key file from "
        f"its machine and name it with --key-file){certificate}, or the rig is of another version of Tendril"
    )
