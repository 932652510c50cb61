"""Commissioning on the wire and in its file. SI units."""

from datetime import datetime
from typing import Annotated, Literal, get_args

from pydantic import Field as Bounds
from pydantic import JsonValue

from controller.schema.commissioned import STEPS as STEPS
from controller.schema.commissioned import StepName as StepName
from controller.schema.layout import Model

TITLES: dict[StepName, str] = {
    "drivers": "Drivers",
    "jog": "Chambers",
    "frame": "Frame",
    "signs": "Signs",
    "pressure": "Pressure steps",
    "statics": "Static sweep",
    "decay": "Free decays",
    "identify": "Actuator",
    "closed_loop": "First closed loop",
}
Chamber = Literal["u1+", "u1-", "u2+", "u2-"]
CHAMBERS: tuple[Chamber, ...] = get_args(Chamber)
Place = Literal["base", "tip", "bent"]
PLACES: tuple[Place, ...] = get_args(Place)
PointName = Annotated[str, Bounds(min_length=1, max_length=80)]
Four = Annotated[list[float | None], Bounds(min_length=4, max_length=4)]
"""Of the chambers u1+, u1-, u2+, u2-; null for what is not a number."""


class StartBody(Model):
    """Body of POST /api/commissioning/{step}/start; each step takes what concerns it and leaves the rest alone."""

    pressure: Annotated[float, Bounds(ge=5e3, le=150e3)] | None = None
    """Of a chamber [Pa]: jog, frame and signs take at most 40 kPa and a fifth of full, the pressure steps at most half
    of full; null: as much as that step usually takes."""
    repeats: Annotated[int, Bounds(ge=1, le=6)] = 3
    """Up and down (pressure), releases to each side (decay; two tell a damping ratio), laps (closed_loop)."""
    grid: Annotated[int, Bounds(ge=3, le=9)] = 5
    """Torques of each pair in the static sweep."""
    share: Annotated[float, Bounds(ge=0.2, le=0.9)] = 0.7
    """How far sweep and decays go towards the admissible torques; decays no further than until the tip is 0.3 of the
    length off its rest."""


class JogBody(Model):
    """Body of PUT /api/commissioning/jog: sent at 5 Hz at least while a button is held, null at its release."""

    chamber: Chamber | None


class ConfirmBody(Model):
    """Body of PUT /api/commissioning/jog/confirm."""

    commanded: Chamber
    """The chamber that was jogged."""
    filled: Chamber
    """The chamber that the operator saw fill."""


class CaptureBody(Model):
    """Body of PUT /api/commissioning/frame/capture."""

    place: Place
    """base: the clamp; tip: the tip at rest; bent: the tip while u1+ is filled, which this request does by itself."""
    point: PointName | None = None
    """Name of the point among the raw values of motion capture; null where there is only one."""


class Change(Model):
    """A value of the rig file that `accept` writes."""

    field: str
    """As "valves.chambers"."""
    before: JsonValue
    """As the file has it; null where it says nothing."""
    after: JsonValue


class Number(Model):
    """A number that a step found."""

    name: str
    value: float | None
    unit: str
    low: float | None = None
    """Of the 95 % interval; null where there is none."""
    high: float | None = None
    bound: str = ""
    """What it must keep, as "at most 0.05 s"; "" where it is only told."""
    kept: bool = True
    """It keeps that."""


class StepView(Model):
    """One step as the page shows it."""

    name: StepName
    title: str
    purpose: str
    """What it does, in one sentence."""
    state: Literal["todo", "running", "done", "failed"]
    """done: it came to a result that may be accepted; failed: to one that may not, or to none."""
    accepted: bool
    """Its result was accepted, and is in the rig file."""
    result: str
    """What came of it, or why nothing did; "" before the first time."""
    numbers: list[Number]
    writes: list[Change]
    """What `accept` would write, or has written."""
    lacks: str
    """What the rig lacks until this step is done, as "frame assumed, not measured"; "" once it is."""
    withdrawn: str
    """Why it stands no longer though it was accepted, as "valves.chambers changed since it was accepted"; else ""."""
    needs: list[str]
    """What is missing to begin; empty: it may be started."""
    by: str
    at: datetime | None
    """Who did it last, and when."""


class Progress(Model):
    """The step under way."""

    step: StepName
    doing: str
    share: Annotated[float, Bounds(ge=0.0, le=1.0)]
    """Of the whole step that is done; 0 while it waits for the operator."""
    waits: bool
    """It waits for the operator: a button to hold, a place to touch."""
    by: str


class Jogged(Model):
    """A chamber that was jogged, and what came of it."""

    commanded: Chamber
    rises: Four
    """By how much each chamber's pressure rose [Pa]."""
    rose: Chamber | None
    """The one whose sensor rose; null where none did enough, or several."""
    filled: Chamber | None
    """The one that the operator saw fill; null until that is confirmed."""


class JogView(Model):
    """The jog under way, or the last one."""

    held: Chamber | None
    """The chamber that is filled now."""
    pressure: float
    """To which it is filled [Pa]."""
    pressures: Four
    """Measured now [Pa]."""
    jogged: list[Jogged]


class Captured(Model):
    """A point that was touched, in the camera's coordinates."""

    place: Place
    point: str
    at: Annotated[list[float], Bounds(min_length=3, max_length=3)]
    """Median over half a second [m, or what the camera takes for it]."""
    spread: float
    """Standard deviation of its distance from there [same unit]."""


class CommissioningState(Model):
    """How far the commissioning of the rig is."""

    available: bool
    reason: str
    """Why it is not available here, "" if it is."""
    rig: str
    steps: list[StepView]
    running: Progress | None
    jog: JogView | None
    """Of the jog step; null before it was first started."""
    captured: list[Captured]
    """Of the frame step."""
    complete: bool
    missing: list[str]
    """What the rig lacks, as "frame assumed, not measured"; empty when it is commissioned."""
