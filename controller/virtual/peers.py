"""The far ends of the wires: what the virtual rig needs of each, and what each sees of the plant.

A peer speaks its wire for real, and may be unplugged and plugged in again at any time, as a device is.
"""

from collections.abc import Callable
from typing import NamedTuple, Protocol

from controller.arrays import Array


class Drive(NamedTuple):
    """What the valves were told last, by board channel."""

    pressures: Array
    """(16,) setpoints [Pa]."""
    openings: Array
    """(16,) -1 to 1; used where the board is driven raw."""
    raw: bool
    vent: bool
    """Every chamber is open to the atmosphere."""
    cut: bool
    """The supply is cut."""


ReadPressures = Callable[[], Array]
"""The plant's gauge pressures by board channel, (16,) [Pa]."""
TakeDrive = Callable[[Drive], None]
LATENCY = "latency"
"""A line to the virtual rig that breaks nothing, and asks how old its camera's frames are when they leave."""


class Peer(Protocol):
    """One device on its wire."""

    @property
    def options(self) -> dict[str, str | int]:
        """What a driver's options must be to reach it, where the rig file leaves them open (port 0, a pty)."""

    def plug(self) -> None:
        """Begin to listen and answer; raises OSError."""

    def unplug(self) -> None:
        """Vanish at once, as a cable that is pulled; `plug` brings it back."""


class CapturePeer(Peer, Protocol):
    """A camera."""

    def show(self, t_ns: int, points: Array, labels: tuple[str, ...]) -> None:
        """Send a frame that was captured at `t_ns` (this machine's monotonic clock): points (M,3) [m], "" unlabelled.

        Points that are nan are not seen.
        """


class ValvePeer(Peer, Protocol):
    """A board with valves, built with `ReadPressures` and `TakeDrive`. It has a watchdog of its own, as a real one."""

    def reset(self) -> None:
        """It begins again, as after its reset button."""

    def freeze(self) -> None:
        """Its program hangs."""

    def thaw(self) -> None:
        """After `freeze`."""

    def half_frame(self) -> None:
        """Its next answer is cut in half."""

    def close(self) -> None:
        """Unplug it for good, and leave nothing behind."""
