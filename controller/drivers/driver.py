"""What the rig process asks of a plant, simulated or real."""

from collections.abc import Callable
from typing import Protocol

import numpy as np

from controller.assembly.plant import Plant
from controller.schema.hardware import DriverStatus

Post = Callable[[np.ndarray], None]
"""Takes an array of one Measurement record; never from two threads at once."""
Newest = Callable[[], np.void | None]
"""The newest Telemetry row; None before the first tick."""
NewestCommand = Callable[[], np.void]
"""The newest ValveCommand record of the loop."""


class Driver(Protocol):
    """A plant with whatever threads it needs. Valves must close by themselves when nothing comes: no process can."""

    simulated: bool
    """True for the twin: pages and recordings say so."""

    @property
    def plant(self) -> Plant:
        """What the loop steps after every tick."""

    def start(self, post: Post, newest: Newest, command: NewestCommand) -> None:
        """Begin to post measurements (captured on the monotonic clock) and to follow the loop's commands."""

    def stop(self) -> None:
        """Follow the last, vented command, then end every thread."""

    def status(self) -> tuple[DriverStatus, ...]:
        """How each device fares now; none of a twin."""

    def unready(self) -> str:
        """Why the rig must not be armed now; "" where it may."""
