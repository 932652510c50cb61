"""What the rig process asks of a plant."""

from collections.abc import Callable
from typing import Protocol

import numpy as np

Post = Callable[[np.ndarray], None]
"""Takes an array of one Measurement record; from one thread of the driver only."""
Newest = Callable[[], np.void | None]
"""The newest Telemetry row; None before the first tick."""


class Driver(Protocol):
    """A plant with whatever threads it needs. Valves must close by themselves when nothing comes: no process can."""

    simulated: bool
    """True for the twin: pages and recordings say so."""

    def start(self, post: Post, newest: Newest) -> None:
        """Begin to post measurements (captured on the monotonic clock) and to follow `pressure_cmd`."""

    def stop(self) -> None:
        """Follow the last, vented row, then end every thread."""
