"""The last measurement of each actuator of a rig, kept over a restart of the server."""

from pathlib import Path
from typing import Annotated

from pydantic import TypeAdapter

from controller.schema.actuator import Actuator, same_body
from controller.schema.messages import RigInfo
from controller.schema.parameters import RigParameters
from controller.system.state_file import StateFile
from server.hardware.first_mode.messages import KeptMode, Plant, as_measured
from server.http.given import given

MODES_MAX = 50
"""Actuators that are kept; the oldest measurement goes first."""
_LIST: TypeAdapter[list[KeptMode]] = TypeAdapter(list[KeptMode])


class FirstModes:
    """Reads and writes the file; one that cannot be used counts as nothing measured, and the log says so."""

    def __init__(self, path: Path) -> None:
        self._file = StateFile(path, _LIST.validate_json, "damping and kappa count as not measured")

    def of(self, actuator: Actuator, plant: Plant | None = None) -> KeptMode | None:
        """The last measurement of this very actuator on `plant`, on any without it; None before the first."""
        kept = (one for one in self._kept() if same_body(one.actuator, actuator))
        return next((one for one in kept if plant in (None, one.plant)), None)

    def twin_of(self, info: RigInfo) -> RigParameters:
        """The rig of `info` with a twin that swings as its devices were measured to, for what is foreseen."""
        return as_measured(info.parameters, self.of(info.parameters.actuator, plant_of(info)))

    def keep(self, one: KeptMode) -> None:
        """Keep it in place of what was measured on the same; raises OSError where that fails."""
        others = [
            kept for kept in self._kept() if kept.plant != one.plant or not same_body(kept.actuator, one.actuator)
        ]
        self._file.path.parent.mkdir(parents=True, exist_ok=True)
        self._file.write(_LIST.dump_json([one, *others][:MODES_MAX]))

    def _kept(self) -> list[KeptMode]:
        return self._file.read() or []


def modes_file(state: Path, rig: str) -> Path:
    """Where a rig's measurements are kept, in the state folder."""
    return state / f"first-mode-{rig}.json"


def plant_of(info: RigInfo) -> Plant:
    """What moves: hardware, or what simulates it."""
    return info.parameters.twin.plant if info.twin else "hardware"


GivenFirstModes = Annotated[FirstModes, given(FirstModes)]
