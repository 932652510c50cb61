"""What a lab's rig is made of beside the actuator: its motion capture, its valves, and how their drivers fare.

The rig file (`controller/schema/rig_file.py`) holds what `Hardware` does; the rig process hands out `DriverStatus`, and
the page shows it.
"""

import math
from typing import Annotated, Literal, Self

from pydantic import BeforeValidator, model_validator
from pydantic import Field as Bounds

from controller.errors import spelled
from controller.schema.commissioned import Commissioned
from controller.schema.layout import Model
from controller.schema.layout import Quantity as Q

RODS = 10
"""Sensor positions along the backbone, as `parameters.SENSORS`."""
CHANNELS = 16
"""Most valve channels of a board."""
ACROSS = 0.1
"""Sine of the least angle between the axes of a frame."""

DriverName = Annotated[str, spelled(r"^[A-Za-z0-9_-]{1,40}$", "1 to 40 letters (a to z), digits and _ -, no blanks")]


def _plain(value: object) -> object:
    """A value that TOML writes in one line without braces."""
    kinds = {type(one) for one in (value if isinstance(value, list) else [value])}
    if not (kinds <= {int, float} or kinds in ({str}, {bool})):
        raise ValueError("is neither a text, a number, true or false, nor a list of texts or of numbers")
    return value


Option = Annotated[str | int | float | bool | list[int] | list[float] | list[str], BeforeValidator(_plain)]
Options = dict[str, Option]
"""What a driver is told; each driver checks its own."""
Coefficient = Annotated[float, Bounds(ge=-1e4, le=1e4)]
Axis = Annotated[tuple[Coefficient, Coefficient, Coefficient], Q("1", shape=(3,))]
Place = Annotated[float, Bounds(ge=-100.0, le=100.0)]
Channel = Annotated[int, Bounds(ge=0, lt=CHANNELS)]
RodNumber = Annotated[int, Bounds(ge=1, le=RODS)]


class Frame(Model):
    """From the camera's coordinates to the plane's: p = axes c + origin, in metres."""

    axes: Annotated[tuple[Axis, Axis], Q("1", shape=(2, 3))] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    """The plane's x and y as combinations of the camera's axes: unit vectors where the camera measures metres."""
    origin: Annotated[tuple[Place, Place], Q("m", shape=(2,))] = (0.0, 0.0)
    """Where the camera's origin lies in the plane."""
    measured: bool = False
    """Found in this rig, not assumed."""

    @model_validator(mode="after")
    def _a_plane(self) -> Self:
        (a, b, c), (d, e, f) = self.axes
        lengths = math.hypot(a, b, c) * math.hypot(d, e, f)
        if math.hypot(b * f - c * e, c * d - a * f, a * e - b * d) <= ACROSS * lengths:
            raise ValueError(f"axes = {[list(axis) for axis in self.axes]} do not span a plane")
        return self


class MotionCapture(Model):
    """Where markers come from, and which of them sits on which rod."""

    driver: DriverName
    options: Options = Bounds(default={})
    frame: Frame = Frame()
    rods: Annotated[tuple[RodNumber, ...], Bounds(min_length=1, max_length=RODS)] = (10,)
    """Rods that bear a marker, at their distal ends: 10 is the tip."""
    labels: dict[str, RodNumber] = Bounds(default={})
    """Names that the camera gives to markers, and their rods. Points without a name are told apart by where the
    observer expects them."""
    gate: Annotated[float, Bounds(ge=0.002, le=1.0), Q("m")] = 0.06
    """A point further than this from where every free rod is expected belongs to none."""
    quality_min: Annotated[float, Bounds(ge=0.0, le=1.0), Q("1")] = 0.0
    """A point of less quality counts as not seen."""

    @model_validator(mode="after")
    def _each_once(self) -> Self:
        if len(set(self.rods)) != len(self.rods):
            raise ValueError(f"rods = {list(self.rods)} names one twice")
        if missing := sorted(set(self.labels.values()) - set(self.rods)):
            raise ValueError(f"labels name rod {missing[0]}, which rods = {list(self.rods)} does not")
        return self


class PressureLoop(Model):
    """The loop from pressure error to valve opening that our tick runs for raw valves."""

    inflate_gain: Annotated[float, Bounds(ge=0.0, le=1e-2), Q("1/Pa")] = 2e-6
    """Opening per pressure error below the setpoint."""
    exhaust_gain: Annotated[float, Bounds(ge=0.0, le=1e-2), Q("1/Pa")] = 4e-6
    """The same above it."""
    integral_time: Annotated[float, Bounds(ge=0.01, le=100.0), Q("s")] = 0.5
    """Reset time. These three are slow on purpose: the pressure step of the commissioning finds better ones."""


class Valves(Model):
    """What fills and empties the four chambers."""

    driver: DriverName
    options: Options = Bounds(default={})
    chambers: Annotated[tuple[Channel, Channel, Channel, Channel], Q("1", shape=(4,))] = (0, 1, 2, 3)
    """Channels of the board at which the chambers u1+, u1-, u2+, u2- hang."""
    command: Literal["pressure", "opening"] = "pressure"
    """What the valves take: setpoints of pressure, which they hold themselves, or raw openings from our own loop."""
    loop: PressureLoop = PressureLoop()
    """For raw openings."""
    pressure_max: Annotated[float, Bounds(gt=0.0, le=1e6), Q("Pa")] = 300e3
    """No setpoint above this leaves, and no torque is asked for that would need one."""
    slew_max: Annotated[float, Bounds(ge=1e3, le=1e9), Q("Pa/s")] = 20e6
    """No setpoint rises or falls faster."""
    measured: bool = False
    """Dead time, lag and map were found in this rig, not assumed."""

    @model_validator(mode="after")
    def _each_once(self) -> Self:
        if len(set(self.chambers)) != 4:
            raise ValueError(f"chambers = {list(self.chambers)} names a channel twice")
        return self


class Hardware(Model):
    """A rig that is not simulated."""

    motion_capture: MotionCapture
    valves: Valves
    commissioned: Commissioned = "missing"
    """Whether drivers, chambers, frame and signs were accepted: without, the rig is armed for those steps only."""

    def __hash__(self) -> int:
        """By what it says, as options are dicts: what is kept for a rig's parameters is looked up by them."""
        return hash(self.model_dump_json())


class DriverStatus(Model):
    """How one driver of the rig fares, looked at now."""

    role: Literal["motion_capture", "valves"]
    driver: str
    device: str
    """What it talks to, as "/dev/ttyACM0 at 1000000 baud"."""
    state: Literal["opening", "running", "silent", "lost"]
    """silent: open, and nothing usable comes."""
    detail: str
    """One sentence for the operator, "" where nothing is wrong. What is said of a running device that obeys, as that
    its answers come late, keeps no one from arming."""
    capabilities: tuple[str, ...]
    """As "two-way clock", "unlabelled markers", "raw openings"."""
    rate: Annotated[float, Q("1/s")]
    """Usable frames a second, lately."""
    age: Annotated[float, Q("s")]
    """Of the newest usable one; -1 before the first."""
    latency: Annotated[float, Q("s")]
    """From capture to arrival here, median of late; -1 where it is not known."""
    clock: Literal["two-way", "one-way", "arrival"]
    """How times of capture come to our clock: by questions and answers, by the quickest arrivals, or not at all."""
    clock_offset: Annotated[float, Q("s")]
    """Ours minus the device's, lately."""
    frames: int
    lost: int
    """Frames that the device numbered and that did not come."""
    rejected: int
    """What came and was no frame, or held impossible numbers."""
    late: int = 0
    """Answers that came after the driver's timeout, and were used all the same."""
    reconnects: int
    values: dict[str, list[float | None]]
    """The newest raw ones, by name: as they came, before any transform; None for what is not a number."""


class Drivers(Model):
    """How all of a rig's drivers fare; none where its plant is simulated."""

    drivers: tuple[DriverStatus, ...]
