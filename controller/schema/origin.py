"""Where figures and files come from: what it takes to make them again, and what the codes in them mean."""

import contextlib
import hashlib
import json
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime
from enum import IntEnum
from pathlib import Path
from typing import Any

from pydantic import AwareDatetime
from pydantic import Field as Bounds

from controller.schema.actuator import Actuator
from controller.schema.layout import Model
from controller.schema.modes import Cause, Law, Mode
from controller.schema.parameters import (
    SENSORS,
    ControllerParameters,
    RigParameters,
    SafetyLimits,
    Settings,
    TwinParameters,
)
from controller.system.origin import commit, our_version

Codes = dict[str, dict[str, int]]


def _named(words: type[IntEnum]) -> dict[str, int]:
    return {word.name: int(word) for word in words}


CODES: Codes = {
    "mode": _named(Mode),
    "cause": _named(Cause),
    "request_cause": _named(Cause),
    "law": _named(Law),
    "sensed": {f"rod_{rod}": 1 << (rod - 1) for rod in range(1, SENSORS + 1)},
}
"""Names of the values of telemetry's codes; of a bitmask, those of its bits."""


class Origin(Model):
    """Stands under the key `origin` in the JSON of every command, and in every file that is exported. SI units."""

    version: str
    commit: str
    """Of the sources, "changed" if anything in them differed; "" if unknown."""
    date: AwareDatetime
    """When the figures were made, or the file was written."""
    command: str = ""
    """As it was typed; "" for what a server wrote."""
    actuators: tuple[Actuator, ...] = ()
    settings: Settings | None = None
    """Gains, law and sensed rods; of a recording those at its start."""
    controller: ControllerParameters | None = None
    limits: SafetyLimits | None = None
    """Of the watchdogs."""
    plant: TwinParameters | None = None
    """The simulated actuator; null on hardware."""
    seeds: tuple[int, ...] = ()
    """Of the plant's noise, one a run."""
    files: Mapping[str, str] = Bounds(default_factory=dict)
    """SHA-256 of each file that was read, by its name."""
    recorded_by: str = ""
    """The version of Tendril that recorded what was exported; "" where there is no recording."""
    codes: Codes = CODES


def origin(command: str = "", **more: Any) -> Origin:
    """That of what is made here and now."""
    return Origin(
        version=our_version(), commit=commit(), date=datetime.now(UTC).replace(microsecond=0), command=command, **more
    )


def origin_of_rig(parameters: RigParameters, command: str = "", simulated: bool = True, **more: Any) -> Origin:
    """The same with the numbers of a rig, and unless it is not `simulated` those of the twin."""
    numbers = {"actuators": (parameters.actuator,), "controller": parameters.controller, "limits": parameters.limits}
    plant = {"plant": parameters.twin, "seeds": (parameters.twin.seed,)} if simulated else {}
    return origin(command, **(numbers | plant | more))


def comment_lines(origin: Origin | None) -> str:
    """`# name: JSON` for each part of `origin`, to stand before a table; "" without one."""
    parts = origin.model_dump(mode="json") if origin else {}
    return "".join(f"# {name}: {json.dumps(value)}\n" for name, value in parts.items())


def hashes(files: Iterable[Path]) -> dict[str, str]:
    """SHA-256 of `files` by name; what cannot be read, or once only as a pipe, is left out."""
    found = {}
    for path in files:
        with contextlib.suppress(OSError):
            if path.is_file():
                found[path.name] = sha256(path)
    return found


def sha256(path: Path) -> str:
    """That of what the file at `path` holds, in hexadecimal digits."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
