"""Who may open a session with the rig, and what either end of it may say.

- A session is opened only to those who have the rig's key: zenoh's user and password, where the password is made from
  the key. It is never sent: the rig asks for an HMAC over a number that it draws for every connection.
- On an open session the server asks and the rig tells, on every key of ours, by one rule; all else is denied. So no end
  can answer in the rig's place, publish its telemetry, or have the rig pass anything on to another server.

This keeps others out of the session; what passes on it is signed as well (seal.py, proof.py), because on a plain TCP
line others can sit between the two ends.
"""

import hmac
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from controller.errors import KeyRefused

USER = "tendril"
OURS = "tendril/**"
"""Every key of every rig."""
ASKS = ("declare_subscriber", "query", "declare_liveliness_subscriber", "liveliness_query")
"""What a server sends, and a rig takes."""
TELLS = ("put", "reply", "declare_queryable", "liveliness_token")
"""What a rig sends, and a server takes."""
PROBE_MAX_S = 0.5
"""For each step of a probe."""
NONSENSE = b"\x01\x00" + b"\xff" * 62
"""No message of zenoh's, nor of TLS: either says so before it ends the connection."""
_DOMAIN = b"tendril session 1"


@contextmanager
def guarded(key: bytes, listens: bool) -> Iterator[dict[str, Any]]:
    """Settings of zenoh for the rig, which `listens`, or for a server; good for `zenoh.open` within the context."""
    with _credentials(password(key), listens) as credentials:
        yield {"transport/auth/usrpwd": credentials, "access_control": _access(listens)}


def password(key: bytes) -> str:
    """What opens a session, and nothing else: neither seals nor proofs can be made with it."""
    return hmac.digest(key, _DOMAIN, "sha256").hex()


def probe(endpoint: str) -> KeyRefused | None:
    """Why no session is opened where something answers at `endpoint` (tcp/HOST:PORT or tls/...); None: nothing does.

    A rig that stands still or starts answers nothing, though its machine, or one on the way, may take the connection.
    """
    host, port = endpoint.partition("/")[2].rsplit(":", 1)
    try:
        with socket.create_connection((host.strip("[]"), int(port)), PROBE_MAX_S) as line:
            line.settimeout(PROBE_MAX_S)
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


@contextmanager
def _credentials(secret: str, listens: bool) -> Iterator[dict[str, str]]:
    """What zenoh is to know: whom it lets in stands in a file, here one in memory that is gone at once."""
    if not listens:
        yield {"user": USER, "password": secret}
        return
    file = os.memfd_create("tendril-session", os.MFD_CLOEXEC)
    try:
        os.write(file, f"{USER}:{secret}\n".encode())
        yield {"dictionary_file": f"/proc/self/fd/{file}"}
    finally:
        os.close(file)


def _access(listens: bool) -> dict[str, Any]:
    asks, tells = ("ingress", "egress") if listens else ("egress", "ingress")
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": [_rule("asks", ASKS, asks), _rule("tells", TELLS, tells)],
        "subjects": [{"id": "other end"} | ({"usernames": [USER]} if listens else {})],
        "policies": [{"rules": ["asks", "tells"], "subjects": ["other end"]}],
    }


def _rule(name: str, messages: tuple[str, ...], flow: str) -> dict[str, Any]:
    return {"id": name, "permission": "allow", "messages": messages, "flows": [flow], "key_exprs": [OURS]}
