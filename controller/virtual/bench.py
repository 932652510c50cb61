"""A virtual peer with the simplest plant behind it: what `tendril drivers check` tries our own drivers against."""

import math
import threading
import time
from contextlib import suppress
from typing import Any

import numpy as np

from controller.arrays import Array
from controller.drivers.conformance.bench import RADIUS, Driven
from controller.drivers.device import CaptureDevice
from controller.drivers.registry import driver_class
from controller.schema.hardware import CHANNELS
from controller.system.thread import SupervisedThread
from controller.virtual.peers import Drive
from controller.virtual.registry import capture_peer, valve_peer

LAG = 0.05
"""Time constant of a chamber [s]."""
FILL_RATE = 2e6
"""Of a wholly open valve [Pa/s]."""
PRESSURE_MOST = 600e3
"""Of the supply [Pa]."""
FRAME_PERIOD = 1 / 120
TURN = 0.5
"""Turns of the marker a second."""


class Chambers:
    """Sixteen of them, each for itself: a first-order lag to its setpoint, or filled and emptied through a valve."""

    def __init__(self) -> None:
        self.drive = Drive(np.zeros(CHANNELS), np.full(CHANNELS, -1.0), False, True, False)
        self._pressures = np.zeros(CHANNELS)
        self._at = time.monotonic()
        self._lock = threading.Lock()

    def pressures(self) -> Array:
        """Gauge, now (16,) [Pa]."""
        with self._lock:
            self._go_on()
            return self._pressures.copy()

    def take(self, drive: Drive) -> None:
        """The valves are told something else."""
        with self._lock:
            self._go_on()
            self.drive = drive

    def _go_on(self) -> None:
        now = time.monotonic()
        passed, self._at = now - self._at, now
        if self.drive.raw and not self.drive.vent:
            rate = np.clip(self.drive.openings, -1.0, 1.0) * FILL_RATE
            self._pressures = np.clip(self._pressures + rate * passed, 0.0, PRESSURE_MOST)
            return
        goal = np.zeros(CHANNELS) if self.drive.vent else np.minimum(self.drive.pressures, PRESSURE_MOST)
        self._pressures = goal + (self._pressures - goal) * math.exp(-passed / LAG)


class PeerBench:
    """The peer of `driver`; a camera sees a marker called "tip" go round."""

    def __init__(self, driver: str) -> None:
        self.chambers = Chambers()
        self._capture = issubclass(driver_class(driver), CaptureDevice)
        self.peer: Any = (
            capture_peer(driver, {})
            if self._capture
            else valve_peer(driver, {}, self.chambers.pressures, self.chambers.take)
        )
        self._silent = False
        self._camera = SupervisedThread("conformance-camera", self._show)

    @property
    def options(self) -> dict[str, str | int]:
        """By which the driver reaches the peer."""
        found: dict[str, str | int] = self.peer.options
        return found

    def plug(self) -> None:
        """Begin to answer."""
        if self._silent and hasattr(self.peer, "thaw"):
            self.peer.thaw()
        self._silent = False
        self.peer.plug()
        if self._capture and not self._camera.started:
            self._camera.start()

    def unplug(self) -> None:
        """Vanish."""
        self.peer.unplug()

    def silence(self) -> None:
        """Say nothing any more."""
        self._silent = True
        if hasattr(self.peer, "freeze"):
            self.peer.freeze()

    def driven(self) -> Driven | None:
        """What the valves were told last."""
        return None if self._capture else self.chambers.drive

    def close(self) -> None:
        """End everything."""
        self._camera.stop()
        with suppress(OSError):
            self.plug()  # a frozen one hears no end
        self.peer.unplug()
        if hasattr(self.peer, "close"):
            self.peer.close()

    def _show(self) -> None:
        while not self._camera.wait(FRAME_PERIOD):
            if self._silent:
                continue
            now = time.monotonic_ns()
            turned = 2.0 * math.pi * TURN * now * 1e-9
            place = [RADIUS * math.cos(turned), RADIUS * math.sin(turned), 0.0]
            self.peer.show(now, np.array([place]), ("tip",))
