"""Outlets, and chambers that only remember what they were told."""

import time

import numpy as np

from controller.arrays import Array
from controller.drivers.device import Outlet
from controller.schema.hardware import CHANNELS
from controller.virtual.peers import Drive

ANSWER_S = 10.0
"""Longest wait for an answer that is to come: the machine may be busy."""
SETPOINTS = np.array([10e3, 20e3, 30e3, 40e3])


def wanted(pressures: Array = SETPOINTS, openings: Array | None = None) -> Outlet:
    return Outlet(time.monotonic_ns(), False, False, pressures, np.zeros(4) if openings is None else openings)


def vented(cut: bool = False) -> Outlet:
    return Outlet(time.monotonic_ns(), True, cut, SETPOINTS, np.ones(4))


class Plant:
    """Pressures by channel, and every command that came."""

    def __init__(self) -> None:
        self.sensed = np.arange(CHANNELS) * 1e3
        self.drives: list[Drive] = []

    def read(self) -> Array:
        return self.sensed

    def take(self, drive: Drive) -> None:
        self.drives.append(drive)

    @property
    def drive(self) -> Drive:
        return self.drives[-1]

    def vented_within(self, seconds: float) -> float:
        """How long until it vents [s]; more than `seconds` if it does not."""
        begun = time.monotonic()
        while not self.drive.vent and time.monotonic() - begun < seconds:
            time.sleep(0.001)
        return time.monotonic() - begun if self.drive.vent else np.inf
