"""The rig file, as far as the commissioning reads and writes it."""

import asyncio
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from pydantic import JsonValue

from controller.errors import CommandRefused, ParameterError
from controller.schema.rig_file import RigFile, changed, parse_rig_file, write_rig_file
from server.access.permit import Permit
from server.hardware.messages import RigFileState


class Keeper(Protocol):
    """Who keeps the rig file: see `server.hardware.rig_file.RigFileKeeper`."""

    def state(self) -> RigFileState:
        """What lies there now."""

    async def write(self, text: str, permit: Permit) -> None:
        """Put `text` in its place and start the rig with it."""


@dataclass(frozen=True)
class CommissionedFile:
    """The rig file behind its keeper."""

    keeper: Keeper

    def state(self) -> RigFileState:
        """What lies there now."""
        return self.keeper.state()

    async def change(self, changes: dict[str, Any], permit: Permit) -> None:
        """Change values; the rig starts anew only where it is described otherwise by that.

        Raises CommandRefused where there is no file, or the rig cannot start now; ParameterError naming the bound.
        """
        found = await asyncio.to_thread(self.keeper.state)
        if found.rig is None:
            raise CommandRefused(found.reason)
        path = Path(found.path)
        text = changed(found.text, changes, path.name)
        wanted = parse_rig_file(text, path.name)
        if wanted.parameters(path.parent) != found.rig.parameters(path.parent):
            return await self.keeper.write(text, permit)
        permit.require()
        try:
            await asyncio.to_thread(write_rig_file, path, text)
        except OSError as error:
            raise CommandRefused(f"{path} cannot be written: {error.strerror}") from error


def value_of(rig: RigFile, field: str) -> JsonValue:
    """What the rig file has at `field`, as "valves.chambers"; ParameterError where there is no such field."""
    at: Any = rig.model_dump(mode="json")
    for name in field.split("."):
        if not isinstance(at, dict) or name not in at:
            raise ParameterError(f"a rig file has no {field}")
        at = at[name]
    found: JsonValue = at
    return found
