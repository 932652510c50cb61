"""Macros on the wire and in their files. SI units."""

from typing import Annotated, Literal

from pydantic import Field as Bounds

from controller.errors import spelled
from controller.schema.layout import Model
from controller.schema.messages import Coordinate
from recordings.format.messages import Label, Profile
from server.drawing.messages import DrawingName, Name
from server.operate.procedure.procedure import State

MacroName = Annotated[str, spelled(r"^[\w .+()-]{1,40}$", "1 to 40 letters, digits, blanks and _ . + - ( )")]
STEPS_MAX = 100
"""Steps of one macro."""
Laps = Annotated[int, Bounds(ge=1, le=1000)]


class ArmStep(Model):
    """Pressurise; nothing where the rig holds or follows already."""

    do: Literal["arm"]


class HoldStep(Model):
    """Freeze the reference where it is."""

    do: Literal["hold"]


class ClearStep(Model):
    """Unlatch FAULT or E-STOP; nothing where neither is."""

    do: Literal["clear"]


class ReferenceStep(Model):
    """Begin to follow a reference of the library."""

    do: Literal["reference"]
    name: Name
    """In the library, or its title."""
    laps: Laps = 1


class DrawingStep(Model):
    """Begin to follow a saved drawing."""

    do: Literal["drawing"]
    name: DrawingName
    laps: Laps = 1


class TargetStep(Model):
    """Follow a live target at this point, within the limits of the settings."""

    do: Literal["target"]
    x: Coordinate
    """[m]"""
    y: Coordinate
    """[m]"""


class WaitStep(Model):
    """Do nothing for a while."""

    do: Literal["wait"]
    seconds: Annotated[float, Bounds(ge=0.1, le=3600.0)]


class RunEndStep(Model):
    """Wait until the run that is under way is done."""

    do: Literal["run_end"]


class PresetStep(Model):
    """Load a preset of gains, as the Gains panel does."""

    do: Literal["preset"]
    name: Annotated[str, Bounds(min_length=1, max_length=60)]


class RecordStep(Model):
    """Begin a recording."""

    do: Literal["record"]
    name: Annotated[str, Bounds(max_length=80)] = ""
    profile: Profile = "standard"


class RecordEndStep(Model):
    """End the recording."""

    do: Literal["record_end"]


class MarkStep(Model):
    """Set a bookmark in the recording."""

    do: Literal["mark"]
    label: Label = ""


Step = Annotated[
    ArmStep
    | HoldStep
    | ClearStep
    | ReferenceStep
    | DrawingStep
    | TargetStep
    | WaitStep
    | RunEndStep
    | PresetStep
    | RecordStep
    | RecordEndStep
    | MarkStep,
    Bounds(discriminator="do"),
]


class MacroBody(Model):
    """Body of PUT /api/macros/{name}: what is done, in order."""

    steps: Annotated[list[Step], Bounds(min_length=1, max_length=STEPS_MAX)]


class Macro(MacroBody):
    """One that is kept."""

    name: MacroName


class MacroState(Model):
    """How the last macro goes, or how it ended."""

    name: str
    learning: bool = False
    """It is no macro: what has this name is repeated, and learned."""
    by: str
    """Who runs it."""
    state: State
    step: int
    """From 1 on; the last one that was begun."""
    steps: int
    doing: str
    """That step in words."""
    reason: str
    """Why it ended, "" otherwise."""


def words(step: Step) -> str:
    """What a step does, as people read it."""
    match step:
        case ReferenceStep() | DrawingStep():
            return f"follow {step.name}" + (f", {step.laps} laps" if step.laps > 1 else "")
        case TargetStep():
            return f"target to ({1e3 * step.x:.1f}, {1e3 * step.y:.1f}) mm"
        case WaitStep():
            return f"wait {step.seconds:g} s"
        case PresetStep():
            return f"load gains {step.name}"
        case RecordStep():
            return "record" + (f" {step.name}" if step.name else "")
        case MarkStep():
            return "bookmark" + (f" {step.label}" if step.label else "")
        case _:
            return {"run_end": "wait for the end of the run", "record_end": "end the recording"}.get(step.do, step.do)
