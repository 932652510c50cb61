"""A bench without a wire, and a driver for it that keeps to everything."""

import threading
import time
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field as Bounds

from controller.drivers.conformance.bench import Driven
from controller.drivers.device import DeviceError, Outlet, Reading, ValveDevice
from controller.schema.hardware import CHANNELS
from controller.schema.layout import Model
from controller.virtual.bench import Chambers
from controller.virtual.peers import Drive

WATCHDOG_S = 0.2


class BenchInMemory:
    """Chambers without a wire: a board that obeys at once, and vents by its own watchdog."""

    def __init__(self) -> None:
        self.chambers = Chambers()
        self.up = self.speaks = True
        self.heard = 0.0
        self.options: dict[str, str | int] = {}

    def plug(self) -> None:
        self.up = self.speaks = True

    def unplug(self) -> None:
        self.up = False

    def silence(self) -> None:
        self.speaks = False

    def driven(self) -> Driven:
        if time.monotonic() - self.heard > WATCHDOG_S:
            self.tell(np.zeros(CHANNELS), vent=True)
        return self.chambers.drive

    def tell(self, pressures: Any, vent: bool, cut: bool = False) -> None:
        self.chambers.take(Drive(pressures, np.zeros(CHANNELS), False, vent, cut))


class GoodOptions(Model):
    port: Annotated[int, Bounds(ge=1, le=65535)] = 4000
    gain: Annotated[float, Bounds(gt=0.0, le=2.0)] = 1.0


class Good(ValveDevice[GoodOptions]):
    """Keeps to everything; the bad ones of the tests change one thing each."""

    Options: Any = GoodOptions
    period = 0.005
    bench: ClassVar[BenchInMemory]

    def __init__(self, options: GoodOptions, chambers: tuple[int, ...], raw: bool) -> None:
        super().__init__(options, chambers, raw)
        self._open, self._closed = False, threading.Event()

    @property
    def name(self) -> str:
        return "memory"

    def open(self) -> None:
        if not self.bench.up:
            raise DeviceError("unplugged")
        self._open = True
        self._closed.clear()

    def close(self) -> None:
        self._open = False
        self._closed.set()

    def exchange(self, outlet: Outlet, timeout: float) -> Reading | None:
        if not (self._open and self.bench.up):
            raise DeviceError("unplugged")
        if not self.bench.speaks:
            if self._closed.wait(timeout):
                raise DeviceError("closed")
            return None
        self.send(outlet)
        return self.reading()

    def send(self, outlet: Outlet) -> None:
        self.bench.heard = time.monotonic()
        vent = outlet.vent or outlet.cut or not bool(np.isfinite(outlet.pressures).all())
        wanted = np.zeros(CHANNELS)
        wanted[list(self.chambers)] = 0.0 if vent else np.clip(outlet.pressures, 0.0, 300e3)
        self.bench.tell(wanted, vent, outlet.cut)

    def reading(self) -> Reading:
        return Reading(time.monotonic_ns(), self.bench.chambers.pressures()[list(self.chambers)])
