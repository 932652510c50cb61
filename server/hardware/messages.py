"""What the page says and hears about a rig's devices and its file."""

from typing import Annotated

from pydantic import Field as Bounds

from controller.schema.layout import Model
from controller.schema.rig_file import SIZE_MAX, RigFile


class RigFileText(Model):
    """Body of PUT /api/rig-file."""

    text: Annotated[str, Bounds(max_length=SIZE_MAX)]
    """Of the whole file, TOML."""


class RigFileState(Model):
    """The rig file as it is on the disk of this server."""

    path: str
    """"" where the rig was started without one, or elsewhere."""
    text: str
    rig: RigFile | None
    """What it says; None where it cannot be read, and `reason` says why."""
    reason: str
    """Why it cannot be read or changed here, "" if it can."""
    in_force: bool
    """The rig runs with what it says now."""
