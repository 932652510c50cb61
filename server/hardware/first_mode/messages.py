"""The first mode on the wire and in its file. SI units."""

from datetime import datetime
from typing import Annotated, Literal

from pydantic import Field as Bounds

from controller.schema.actuator import Actuator
from controller.schema.layout import Model
from controller.schema.parameters import PlantKind, RigParameters

Plant = PlantKind | Literal["hardware"]
ASSUMED = "fit to the paper"
"""Where the twin's numbers come from that stand for what was not measured."""


class FirstModeBody(Model):
    """Body of POST /api/first-mode/measure."""

    travel: Annotated[float, Bounds(ge=0.02, le=0.2)] = 0.1
    """How far the tip is to move from one side of its rest to the other [m]."""
    repeats: Annotated[int, Bounds(ge=2, le=6)] = 3
    """Steps there and back."""


class Interval(Model):
    """A measured number with its 95 % interval over the repeats."""

    value: Annotated[float, Bounds(ge=0.0, allow_inf_nan=False)]
    low: Annotated[float, Bounds(ge=0.0, allow_inf_nan=False)]
    high: Annotated[float, Bounds(ge=0.0, allow_inf_nan=False)]


class MeasuredMode(Model):
    """What one measurement came to."""

    frequency: Interval
    """Undamped [Hz]."""
    zeta: Interval
    """Damping ratio."""
    kappa: Interval
    """By which the model's stiffness, torque and gravity are multiplied for that frequency."""
    friction: float
    """By how much dry friction shifts the rest, either way [m]; zeta is without it."""
    delay: float
    """Of the tip behind the torques of the chambers [s]."""
    misfit: float
    """Share of the motion (rms) that such a mode leaves over."""
    pressures: bool
    """Whether measured pressures were the input; else what was sent, delayed and lagged as the observer has it."""
    travel: float
    """That was asked for [m]."""
    repeats: int


class KeptMode(Model):
    """A measurement, and of what."""

    actuator: Actuator
    """It holds for this one alone, number for number."""
    plant: Plant
    measured: datetime
    mode: MeasuredMode


class PlantNumber(Model):
    """A number of the plant that stability rests on."""

    value: float
    source: Literal["assumed", "measured", "given"]
    low: float | None = None
    """Of the 95 % interval; null where it was not measured."""
    high: float | None = None
    measured: datetime | None = None
    note: str = ""
    """Where an assumed one comes from."""


class FirstModeInForce(Model):
    """What is known of the first mode of the rig's actuator."""

    actuator: str
    zeta: PlantNumber
    kappa: PlantNumber
    mode: MeasuredMode | None
    """The last measurement of this actuator on this plant; null before the first."""
    observer_kappa: float
    """With which kappa the observer's own body moves, `controller.observer_kappa`; 1 is the actuator's table."""


class FirstModeState(Model):
    """How the last measurement goes, or how it ended."""

    by: str
    """Who asked for it."""
    state: Literal["running", "done", "ended"]
    """Done: measured; ended: before that, or nothing could be told."""
    doing: str
    """What is done now, or was done last."""
    step: int
    """Steps that were begun."""
    steps: int
    reason: str = ""
    """Why it ended, "" otherwise."""


def in_force(parameters: RigParameters, kept: KeptMode | None) -> FirstModeInForce:
    """The measured numbers where there are any, else the twin's."""
    numbers = {
        name: assumed(getattr(parameters.twin, name)) if kept is None else measured(getattr(kept.mode, name), kept)
        for name in ("zeta", "kappa")
    }
    return FirstModeInForce(
        actuator=parameters.actuator.name,
        mode=kept.mode if kept else None,
        observer_kappa=parameters.controller.observer_kappa,
        **numbers,
    )


def assumed(value: float) -> PlantNumber:
    """The twin's number."""
    return PlantNumber(value=value, source="assumed", note=ASSUMED)


def measured(number: Interval, kept: KeptMode) -> PlantNumber:
    """What was measured."""
    return PlantNumber(value=number.value, source="measured", low=number.low, high=number.high, measured=kept.measured)
