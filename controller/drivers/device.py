"""What a driver of hardware is: one class that opens a device, talks to it and closes it. Everything else is ours.

`controller/drivers/threads.py` gives every device a thread of its own, opens it again when it is lost, counts what
comes and stands between it and the loop: no device, however slow or dead, delays a tick. A driver raises DeviceError
(or OSError) when the device is lost, and returns None when nothing has come in time. `tendril docs drivers` has a
template; `tendril drivers check NAME` tries a driver the hard way.
"""

import time
from abc import ABC, abstractmethod
from typing import ClassVar, Generic, Literal, NamedTuple, Self, TypeVar

import numpy as np

from controller.arrays import Array, Array32
from controller.errors import TendrilError
from controller.schema.layout import Model

O = TypeVar("O", bound=Model)  # noqa: E741  options
Clock = Literal["two-way", "one-way", "arrival"]

POINTS_MAX = 512
"""More points than this are no view of one actuator."""
COORDINATE_MAX_M = 1e3
"""A coordinate beyond this is no measurement."""


class DeviceError(TendrilError):
    """The device is lost, or answers nonsense; the text says which and is fit for an operator."""


class Sample(NamedTuple):
    """What motion capture saw at one moment."""

    t_ns: int
    """Capture, on this machine's monotonic clock."""
    points: Array
    """(M,3) [m] in the camera's frame, or (M,2); nan for what is not seen."""
    labels: tuple[str, ...] = ()
    """Name of each point, "" where it has none; () where none has."""
    quality: Array | None = None
    """(M,) 0 to 1; None: all are good."""
    number: int = -1
    """The device's own count of frames, by which losses are known; -1: it has none."""


def plausible(points: Array | Array32) -> bool:
    """Whether `points`, of any shape, are coordinates [m] of what a camera sees, or nan."""
    return bool(np.all((np.abs(points) <= COORDINATE_MAX_M) | np.isnan(points)))


class Angles(NamedTuple):
    """What sensors of orientation along the backbone saw at one moment: an alternative to `Sample`."""

    t_ns: int
    arcs: Array
    """(K,) arc lengths from the base, rising [m]."""
    angles: Array
    """(K,) of the tangent, from the base's [rad]; nan for what is not known."""
    number: int = -1


class Outlet(NamedTuple):
    """What the loop wants of the valves, newest whole."""

    t_ns: int
    """When it was made, monotonic."""
    vent: bool
    """Open every chamber to the atmosphere: nothing is driven."""
    cut: bool
    """E-STOP: cut the supply, too, past the valves."""
    pressures: Array
    """(4,) gauge setpoints of u1+, u1-, u2+, u2- [Pa], within all limits."""
    openings: Array
    """(4,) valve openings, -1 (exhausts) to 1 (fills), where `valves.command` is "opening"."""

    @classmethod
    def vented(cls, cut: bool = False) -> Self:
        """Now: nothing is driven."""
        return cls(time.monotonic_ns(), True, cut, np.zeros(4), np.full(4, -1.0))

    def wanted(self, raw: bool) -> Array:
        """(4,) what valves that take openings (`raw`) or setpoints are to do."""
        return np.asarray(self.openings if raw else self.pressures, float)

    def vents(self, raw: bool) -> bool:
        """Whether to let the air out: it is asked for, or what is asked for is not finite."""
        return self.vent or self.cut or not bool(np.isfinite(self.wanted(raw)).all())


class Reading(NamedTuple):
    """What the valves' board says."""

    t_ns: int
    """When the pressures were read, on this machine's monotonic clock."""
    pressures: Array
    """(4,) gauge, of u1+, u1-, u2+, u2- [Pa]; nan for a broken sensor."""
    stopped: str = ""
    """Why the board drives nothing although it should, as "its watchdog vented"; "": it obeys."""
    number: int = -1
    """The device's own count of frames; -1: it has none."""


class Device(ABC, Generic[O]):
    """Common to both kinds. `Options` is a model whose fields, bounds and defaults the rig file is checked against."""

    Options: type[O]
    capabilities: ClassVar[tuple[str, ...]] = ()
    clock: Clock = "arrival"
    clock_offset: float = 0.0
    """Ours minus the device's [s], as it is now."""
    rejected: int = 0
    """Frames that were none, counted by the driver."""
    late: int = 0
    """Answers that came after the driver's timeout and were used, counted by the driver."""
    notice: str = ""
    """What an operator should know though it stops nothing, as "answers come after 15 ms, timeout is 10 ms"."""
    period: ClassVar[float] = 0.0
    """For valves: how often `exchange` is called [s]."""

    def __init__(self, options: O) -> None:
        """Keep the options; touch nothing yet."""
        self.options = options

    @property
    @abstractmethod
    def name(self) -> str:
        """What it talks to, as "/dev/ttyACM0 at 1000000 baud"."""

    @abstractmethod
    def open(self) -> None:
        """Connect; raises DeviceError or OSError. Called again after every loss."""

    @abstractmethod
    def close(self) -> None:
        """Let go of everything; never raises, may be called twice."""


class CaptureDevice(Device[O]):
    """Motion capture, or other sensors of shape."""

    @abstractmethod
    def read(self, timeout: float) -> Sample | Angles | None:
        """The next frame; None if none comes within `timeout` [s]."""


class ValveDevice(Device[O]):
    """Valves and the pressure sensors at them; `chambers` are the board's channels of u1+, u1-, u2+, u2-."""

    period = 0.002

    def __init__(self, options: O, chambers: tuple[int, ...], raw: bool) -> None:
        """`raw`: it is to take openings, else setpoints of pressure."""
        super().__init__(options)
        self.chambers, self.raw = chambers, raw

    @abstractmethod
    def exchange(self, outlet: Outlet, timeout: float) -> Reading | None:
        """Send what is wanted and return what the board says; None if it says nothing within `timeout` [s]."""
