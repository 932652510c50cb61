"""How a rig process is started and what it says when it is ready; imports nothing heavy."""

import socket
from pathlib import Path
from typing import Annotated

from controller.errors import spelled
from controller.schema.layout import Model
from controller.schema.parameters import RigParameters
from controller.system.logs import LogFormat

REFUSED = 3
"""Exit code of a process that could not start and has said why, in one sentence."""


class RigSettings(Model):
    """How a rig process is started; `python -m controller.realtime` takes it as JSON."""

    rig: Annotated[str, spelled(r"^[A-Za-z0-9_-]{1,40}$", "1 to 40 letters (a to z), digits and _ -, no blanks")] = (
        "rig"
    )
    listen: Annotated[str, spelled(r"^\w+/.+:\d+$", "PROTOCOL/HOST:PORT, as in tcp/127.0.0.1:7447")] = "tcp/127.0.0.1:0"
    """zenoh endpoint; port 0 takes a free one (see `ready`)."""
    key_file: Path | None = None
    """Key that every server must have which commands this rig; made if it is not there. None: see `key_path`."""
    link_tls: Path | None = None
    """Folder of the certificates for an endpoint tls/...; see `controller.link.keys.open_session`."""
    parameters: RigParameters = RigParameters()
    baseline: bool = False
    """Run a bare thread of the same priority beside the loop and count what it loses."""
    folder: Path | None = None
    """Where ring and lock lie; None: a private folder, see `controller.system.private_folder`."""
    ready: Path | None = None
    """Written when the loop runs and the link answers: a `RigReady` as JSON."""
    log_format: LogFormat = "text"
    parent: int = 0
    """Process without which this rig ends, once it is VENTED; 0: none."""


class RigReady(Model):
    """What a rig says when it is ready."""

    endpoint: str
    boot: int
    process: int


def failure_file(ready: Path) -> Path:
    """Where a rig that could not start says why, beside its file `ready`."""
    return ready.with_suffix(".failed")


def free_port(endpoint: str) -> str:
    """`endpoint` with port 0 replaced by a port that is free now."""
    place, port = endpoint.rsplit(":", 1)
    if port != "0":
        return endpoint
    with socket.socket() as probe:
        probe.bind((place.split("/", 1)[1], 0))
        return f"{place}:{probe.getsockname()[1]}"
