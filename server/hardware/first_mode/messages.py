"""The first mode on the wire and in its file. SI units."""

from datetime import datetime
from typing import Annotated, Literal

from pydantic import Field as Bounds

from controller.schema.actuator import Actuator, is_of_paper
from controller.schema.layout import Model
from controller.schema.parameters import KAPPA, PlantKind, RigParameters, usual_twin

Plant = PlantKind | Literal["hardware"]
FITTED = "fit to the paper"
GIVEN_IN_FILE = "[twin] of the rig file"
IN_FILE = {"zeta": "b and alpha", "kappa": "mass and stiffness"}
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
    source: Literal["assumed", "file", "measured", "given"]
    """Of the fit to the paper, as the actuator's file says, measured on this rig, or asked for."""
    low: float | None = None
    """Of the 95 % interval; null where it was not measured."""
    high: float | None = None
    measured: datetime | None = None
    note: str = ""
    """Where an assumed one comes from, or by what of the file."""


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
        name: of_twin(parameters, name) if kept is None else measured(getattr(kept.mode, name), kept)
        for name in ("zeta", "kappa")
    }
    return FirstModeInForce(
        actuator=parameters.actuator.name,
        mode=kept.mode if kept else None,
        observer_kappa=parameters.controller.observer_kappa,
        **numbers,
    )


def of_twin(parameters: RigParameters, name: str) -> PlantNumber:
    """The twin's number `name`, "zeta" or "kappa", and where it comes from."""
    from controller.assembly.plant_parts import damping_ratio  # not for a start of the server

    twin, usual = parameters.twin, getattr(usual_twin(parameters.body), name)
    value = damping_ratio(parameters.body, twin) if name == "zeta" else twin.kappa
    if getattr(twin, name) != usual:
        return PlantNumber(value=value, source="given", note=GIVEN_IN_FILE if parameters.hardware else "")
    if is_of_paper(parameters.body):
        return PlantNumber(value=value, source="assumed", note=FITTED)
    return PlantNumber(value=value, source="file", note=IN_FILE[name])


def as_measured(parameters: RigParameters, kept: KeptMode | None) -> RigParameters:
    """A rig of devices whose twin swings as they do, where that was measured; a twin's own numbers are known."""
    if parameters.hardware is None or kept is None:
        return parameters
    kappa = min(max(kept.mode.kappa.value, KAPPA[0]), KAPPA[1])
    twin = parameters.twin.model_copy(update={"zeta": kept.mode.zeta.value, "kappa": kappa})
    return parameters.model_copy(update={"twin": twin})


def measured(number: Interval, kept: KeptMode) -> PlantNumber:
    """What was measured."""
    return PlantNumber(value=number.value, source="measured", low=number.low, high=number.high, measured=kept.measured)
