"""Another plant than the fitted one: "k=1.1,delay=0.01" scales the twin's stiffness and adds to its dead time.

The controller's model stays as it is, so this is a mismatch that it does not know of.
"""

import math
from typing import NamedTuple

from pydantic import ValidationError

from controller.assembly.plant_parts import damping_ratio
from controller.errors import ParameterError, sentence
from controller.schema.actuator import PRESETS, Actuator
from controller.schema.parameters import TwinParameters


class Change(NamedTuple):
    """What a key does to a field of `TwinParameters`."""

    field: str
    adds: bool = False
    """Whether the number is added, in the field's unit, instead of multiplied."""


CHANGES = {
    "k": Change("stiffness_scale"),
    "b": Change("zeta"),
    "zeta": Change("zeta"),
    "torque": Change("torque_gain"),
    "friction": Change("friction"),
    "noise": Change("marker_noise"),
    "delay": Change("dead_time", adds=True),
    "latency": Change("marker_latency", adds=True),
}
"""k is the stiffness, b (or zeta) the damping ratio of the first mode, both as factors; delay and latency are in s."""
OWN = ("torque_gain",)
"""Fields that a Cosserat plant has of its own."""


def scaled(twin: TwinParameters, text: str, body: Actuator = PRESETS["P1"]) -> TwinParameters:
    """`twin`, of `body`, with the changes of `text` ("" for none).

    Raises ParameterError for an unknown or repeated key, for what is not a number, and for a plant outside the bounds
    of `TwinParameters`.
    """
    values = twin.model_dump()
    changed: set[str] = set()
    for part in filter(str.strip, text.split(",")):
        change, number = parse(part)
        plant = values["cosserat"] if twin.plant == "cosserat" and change.field in OWN else values
        if change.field in changed:
            raise ParameterError(f"plant-scale: {part.strip()} changes {change.field} a second time")
        changed.add(change.field)
        before = damping_ratio(body, twin) if change.field == "zeta" else plant[change.field]
        plant[change.field] = applied(before, change, number)
    try:
        return TwinParameters.model_validate(values)
    except ValidationError as error:
        raise ParameterError(f"plant-scale = {text!r} leaves the twin's bounds: {sentence(error)}") from error


def parse(part: str) -> tuple[Change, float]:
    """The change that a part like "k=1.1" asks for, and its number."""
    key, equals, value = (piece.strip() for piece in part.partition("="))
    if key not in CHANGES:
        raise ParameterError(f"plant-scale: {key!r} is not one of {', '.join(CHANGES)} (as in k=1.1,delay=0.01)")
    try:
        number = float(value)
    except ValueError:
        number = math.nan
    if not equals or not math.isfinite(number):
        raise ParameterError(f"plant-scale: {key} = {value!r} is not a finite number (as in k=1.1,delay=0.01)")
    return CHANGES[key], number


def applied(value: float | tuple[float, ...], change: Change, number: float) -> float | tuple[float, ...]:
    """`value` of a field, or each of its values, after the change."""
    if isinstance(value, tuple):
        return tuple(one + number if change.adds else one * number for one in value)
    return value + number if change.adds else value * number
