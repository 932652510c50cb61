"""The rig file: everything that one lab's rig is, in TOML: actuator, drivers, markers, frame, valves, limits.

`tendril up --rig rig.toml` runs it, `tendril virtual-rig rig.toml` stands in for its devices, and the page's
commissioning writes what it measures into it. Comments and order of the file stay.
"""

from pathlib import Path
from typing import Annotated, Any

import tomlkit
from pydantic import Field as Bounds
from tomlkit.exceptions import TOMLKitError

from controller.errors import ParameterError, spelled
from controller.schema import commissioned as steps
from controller.schema.actuator import Actuator, read_actuator
from controller.schema.hardware import Hardware, MotionCapture, Valves
from controller.schema.layout import Model
from controller.schema.parameters import ControllerParameters, RigParameters, SafetyLimits, TwinParameters
from controller.system.whole_file import read_whole, write_whole
from controller.text.toml import model_in

SIZE_MAX = 200_000
"""Longest rig file [bytes]."""
RigName = Annotated[str, spelled(r"^[A-Za-z0-9_-]{1,40}$", "1 to 40 letters (a to z), digits and _ -, no blanks")]


class RigFile(Model):
    """What a rig file may say; what it leaves out has its default."""

    name: RigName = "rig"
    """The rig's id: in keys, recordings and paths."""
    actuator: str | Actuator = "P1"
    """P1, P2, P3, an actuator's file beside this one, or the actuator itself as a table."""
    motion_capture: MotionCapture
    valves: Valves
    controller: ControllerParameters = ControllerParameters()
    limits: SafetyLimits = SafetyLimits()
    twin: TwinParameters = TwinParameters()
    """The plant of the virtual rig, and of previews."""
    commissioned: dict[str, Annotated[str, Bounds(max_length=200)]] = Bounds(default={})
    """Steps of the commissioning that are done, and what came of each."""
    stands_on: dict[str, dict[str, str]] = Bounds(default={})
    """A mark of each line on which an accepted step stands: one that changes withdraws the step."""
    arm_uncommissioned: bool = False
    """Arm without drivers, chambers, frame and signs accepted. The page shows it in red for as long as it stands."""

    def parameters(self, folder: Path) -> RigParameters:
        """What a rig process is started with; actuators' files are looked for in `folder`. Raises ParameterError."""
        actuator = self.found_actuator(folder)
        rig = RigParameters(
            actuator=actuator,
            controller=self.controller,
            limits=self.limits,
            twin=self.twin,
            hardware=Hardware(
                motion_capture=self.motion_capture, valves=self.valves, commissioned=self._commissioned(folder)
            ),
        )
        return rig.with_actuator(actuator)

    def values(self, folder: Path) -> dict[str, Any]:
        """All that it says as plain values, the actuator as it is found in `folder`. Raises ParameterError."""
        return self.model_dump(mode="json") | {"actuator": self.found_actuator(folder).model_dump(mode="json")}

    def withdrawn(self, folder: Path) -> dict[steps.StepName, str]:
        """Steps that were accepted and stand no longer, and why. Raises ParameterError."""
        return steps.withdrawn(self.commissioned, self.stands_on, self.values(folder))

    def _commissioned(self, folder: Path) -> steps.Commissioned:
        standing = self.commissioned.keys() - self.withdrawn(folder).keys()
        if standing >= set(steps.GATE):
            return "accepted"
        return "waived" if self.arm_uncommissioned else "missing"

    def found_actuator(self, folder: Path) -> Actuator:
        """The actuator that it names or holds; ParameterError where there is none."""
        if isinstance(self.actuator, Actuator):
            return self.actuator
        return read_actuator(folder / self.actuator if self.actuator.endswith(".toml") else self.actuator)


def read_rig_file(path: Path) -> RigFile:
    """The rig file at `path`; ParameterError names file, field, value and bound."""
    try:
        return parse_rig_file(read_whole(path).decode("utf-8-sig"), str(path))
    except OSError as error:
        raise ParameterError(f"{path} cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise ParameterError(f"{path} is not text: {error}") from error


def parse_rig_file(text: str, source: str) -> RigFile:
    """The rig that the TOML `text` describes; ParameterError names `source`, field, value and bound."""
    if len(text) > SIZE_MAX:
        raise ParameterError(f"{source} has {len(text)} characters: {SIZE_MAX} are the most")
    return model_in(text, source, RigFile)


def changed(text: str, changes: dict[str, Any], source: str) -> str:
    """The TOML `text` with the values of `changes` ("valves.measured": True) put in, all else as it was.

    Raises ParameterError where what comes of it is no rig file.
    """
    try:
        document = tomlkit.parse(text)
        for place, value in changes.items():
            *tables, name = place.split(".")
            at: Any = document
            for table in tables:
                at = at.setdefault(table, tomlkit.table())
            at[name] = value
        found = tomlkit.dumps(document)
    except (TOMLKitError, TypeError, AttributeError) as error:
        raise ParameterError(f"{source} cannot be changed: {error}") from error
    parse_rig_file(found, source)
    return found


def noted(text: str, path: Path, *accepted: steps.StepName) -> str:
    """The rig file `text`, to lie at `path`, with new marks of what was just `accepted`, and of no step that is not."""
    rig = parse_rig_file(text, path.name)
    stands_on = {step: known for step, known in rig.stands_on.items() if step in rig.commissioned}
    values = rig.values(path.parent)
    stands_on |= {step: steps.marks(step, values) for step in accepted if step in rig.commissioned}
    return text if stands_on == rig.stands_on else changed(text, {"stands_on": stands_on}, path.name)


def write_rig_file(path: Path, text: str) -> None:
    """Put `text`, which must be a rig file, in the place of `path`, whole; raises ParameterError, OSError."""
    parse_rig_file(text, str(path))
    write_whole(path, text)
