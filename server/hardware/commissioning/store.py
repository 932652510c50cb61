"""What each step came to, kept over a restart of the server; and the rig file, into which accepted results go."""

import asyncio
import math
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Annotated, Any, NamedTuple, Protocol

from pydantic import Field as Bounds
from pydantic import JsonValue

from controller.arrays import Array
from controller.errors import CommandRefused
from controller.schema.commissioned import StepName, value_at
from controller.schema.layout import Model
from controller.schema.parameters import Settings
from controller.schema.rig_file import RigFile, changed, noted, parse_rig_file, write_rig_file
from controller.system.state_file import StateFile
from server.access.permit import Permit
from server.hardware.commissioning.messages import Number
from server.hardware.messages import RigFileState

KEPT_TEXT = 200
"""Most of a result that the rig file keeps [characters]."""


class Found(NamedTuple):
    """What a step came to."""

    good: bool
    """It may be accepted."""
    text: str
    """In one or two sentences, 200 characters at most where it is good: the rig file keeps it."""
    numbers: tuple[Number, ...] = ()
    changes: dict[str, JsonValue] = {}  # noqa: RUF012  never changed
    """What `accept` writes into the rig file."""
    data: dict[str, JsonValue] = {}  # noqa: RUF012
    """For the steps that rest on it, and for the report's figures."""
    again: bool = False
    """What it writes makes another measurement necessary: it is accepted, and is to be done once more."""


class KeptResult(Model):
    """What a step came to, by whom and when."""

    good: bool
    text: str
    numbers: Annotated[list[Number], Bounds(default_factory=list)]
    changes: Annotated[dict[str, JsonValue], Bounds(default_factory=dict)]
    before: Annotated[dict[str, JsonValue], Bounds(default_factory=dict)]
    """Values of the rig file in the place of `changes`."""
    data: Annotated[dict[str, JsonValue], Bounds(default_factory=dict)]
    again: bool = False
    stands_on: Annotated[dict[str, str], Bounds(default_factory=dict)]
    """A mark of each line of the rig file with which it was done."""
    by: str
    at: datetime


class Kept(Model):
    """The whole file."""

    results: Annotated[dict[StepName, KeptResult], Bounds(default_factory=dict)]
    borrowed: Settings | None = None
    """Settings to be put back: those of the operator, while a step has others in force."""


class CommissioningStore:
    """Reads and writes the file; one that cannot be used counts as nothing done, and the log says so."""

    def __init__(self, path: Path) -> None:
        self._file = StateFile(path, Kept.model_validate_json, "no step of the commissioning counts as done")
        self.kept = self._file.read() or Kept(results={})

    def keep(self, step: StepName, result: KeptResult) -> None:
        """Keep the step's result; raises OSError where the file cannot be written."""
        self._write(self.kept.model_copy(update={"results": self.kept.results | {step: result}}))

    def forget(self, steps: set[StepName]) -> None:
        """Forget what these came to; raises OSError."""
        results = {name: one for name, one in self.kept.results.items() if name not in steps}
        self._write(self.kept.model_copy(update={"results": results}))

    @property
    def overridden(self) -> Settings | None:
        """Settings that are to be put back; None where a step has none in their place."""
        return self.kept.borrowed

    def note_override(self, settings: Settings | None) -> None:
        """Note which settings are to be put back, None once they are; raises OSError."""
        self._write(self.kept.model_copy(update={"borrowed": settings}))

    def _write(self, wanted: Kept) -> None:
        self._file.path.parent.mkdir(parents=True, exist_ok=True)
        self._file.write(wanted.model_dump_json())
        self.kept = wanted


def commissioning_file(state: Path, rig: str) -> Path:
    """Where a rig's results are kept, in the state folder."""
    return state / f"commissioning-{rig}.json"


def data_folder(state: Path, rig: str) -> Path:
    """Where its measured tables lie."""
    return state / f"commissioning-{rig}"


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

    async def change(self, changes: dict[str, Any], permit: Permit, *accepted: StepName) -> None:
        """Change values, and note the lines under what is `accepted` by it; the rig starts again where that needs it.

        Raises CommandRefused where there is no file, or the rig cannot start now; ParameterError naming the bound.
        """
        found = await asyncio.to_thread(self.keeper.state)
        if found.rig is None:
            raise CommandRefused(found.reason)
        path = Path(found.path)
        text = noted(changed(found.text, changes, path.name), path, *accepted)
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
    return value_at(rig.model_dump(mode="json"), field)


def numbers_of(values: Array) -> list[float | None]:
    """(n,) as JSON has them."""
    return [float(value) if math.isfinite(value) else None for value in values]
