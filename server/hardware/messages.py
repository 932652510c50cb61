"""What the page says and hears about a rig's devices, its file and its actuator."""

from typing import Annotated

from pydantic import Field as Bounds

from controller.schema.commissioned import StepName
from controller.schema.layout import Model
from controller.schema.parameters import ObserverKappa, PlantKind
from controller.schema.rig_file import SIZE_MAX, RigFile
from controller.schema.twin_numbers import NUMBERS_MAX


class RigFileText(Model):
    """Body of PUT /api/rig-file."""

    text: Annotated[str, Bounds(max_length=SIZE_MAX)]
    """Of the whole file, TOML."""


class RigFileState(Model):
    """The rig file as it is on the disk of this server."""

    path: str
    """"" where the rig was started without one, or elsewhere."""
    text: str
    rig: RigFile | None
    """What it says; None where it cannot be read, and `reason` says why."""
    reason: str
    """Why it cannot be read or changed here, "" if it can."""
    in_force: bool
    """The rig runs with what it says now."""
    withdrawn: dict[StepName, str] = Bounds(default={})
    """Steps of the commissioning that were accepted and stand no longer, and why."""


class ActuatorBody(Model):
    """Body of PUT /api/rig/actuator: one of the two."""

    name: Annotated[str, Bounds(max_length=40)] | None = None
    """P1, P2 or P3."""
    toml: Annotated[str, Bounds(max_length=400_000)] | None = None
    """Text of an actuator file (docs/actuators.md)."""


class PlantBody(Model):
    """Body of PUT /api/rig/plant."""

    plant: PlantKind
    """What simulates the actuator: rigid rods, as in the model, or a Cosserat rod (docs/model.md)."""
    numbers: Annotated[str, Bounds(max_length=NUMBERS_MAX)] | None = None
    """Numbers of the twin, as kappa=12,zeta=0.2; "" those that are usual with the actuator, null as they are."""


class ObserverKappaBody(Model):
    """Body of PUT /api/rig/observer-kappa."""

    kappa: ObserverKappa
    """Inertia of the actuator's table over that of the observer's body; 1 is the paper's."""


class ActuatorOutcome(Model):
    """What became of an order for another actuator; `tendril up` tells it to its server."""

    actuator: str
    """That was asked for."""
    reason: str = ""
    """Why the rig does not run with it, "" if it does."""
    in_force: str
    """The actuator with which the rig is started now."""
    unkept: str = ""
    """Why the next `tendril up` will not begin with it, "" if it will."""


class ActuatorChoice(Model):
    """What the rig may be started with."""

    names: list[str]
    """Actuators that come with Tendril."""
    reason: str
    """Why another one cannot be chosen here, "" if it can."""
    failure: str = ""
    """Why the last one that was chosen is not in force, "" if it is."""
