"""A driver on trial: each of its calls in a thread that may hang, and what is expected of every one."""

import time
from collections.abc import Callable, Iterator
from concurrent.futures import wait
from contextlib import contextmanager, suppress
from typing import Any, TypeVar

import numpy as np

from controller.arrays import Array
from controller.drivers.conformance.bench import Bench, Driven
from controller.drivers.conformance.recorder import Recorder
from controller.drivers.device import Device, DeviceError, Outlet, ValveDevice
from controller.system.thread import in_thread

T = TypeVar("T")
OURS = "conformance"
"""Name of our own threads: they are not counted as the driver's."""
TIMEOUT = 0.1
"""That each read and exchange is called with [s]."""
MARGIN = 0.1
"""By which it may come back later [s]."""
HANGS = 3.0
"""By which a call may come back later before it is given up [s]."""
OPEN_LIMIT = 30.0
"""Longest that open may take [s]."""
CLOSE_LIMIT = 1.0
"""Longest that close may take [s]."""
ROUNDS = 3
"""Times that the vented command is sent in the end."""


class Failed(Exception):
    """The driver does not keep to the protocol; the text says how."""


class NotShown(Exception):
    """It was neither seen to hold nor to fail."""

    def __init__(self, why: str, remedy: str) -> None:
        """`remedy`: what would show it."""
        super().__init__(f"{why}; what would show it: {remedy}")


def within(limit: float, what: str, work: Callable[[], T]) -> T:
    """The result of `work`, or what it raises; Failed if it does not come within `limit` [s]."""
    found = in_thread(OURS, work)
    if not wait([found], limit).done:
        raise Failed(f"{what} did not return within {limit:g} s")
    return found.result()


def require(holds: bool, text: str) -> None:
    """Failed with `text` unless it `holds`."""
    if not holds:
        raise Failed(text)


class Trial:
    """Makes devices of one kind, and calls them."""

    def __init__(self, kind: type[Device[Any]], options: dict[str, Any], wire: Bench | None, drive: bool) -> None:
        """`drive`: pressures may be commanded to a real device, too."""
        self.kind, self.wire = kind, wire
        self.recorder = wire if isinstance(wire, Recorder) else None
        """Between the driver and a real device."""
        self.bench = None if self.recorder is not None else wire
        """What stands for the device: it knows what its valves do."""
        self.options = options | (dict(wire.options) if wire is not None else {})
        self.drive = drive or self.bench is not None
        self.valves = issubclass(kind, ValveDevice)
        self.chambers = (1, 0, 3, 2)
        """Not in the order of the channels, so that a driver that forgets them is found."""

    def device(self) -> Device[Any]:
        """A new one, not open."""
        options = self.kind.Options.model_validate(self.options)
        if issubclass(self.kind, ValveDevice):
            return self.kind(options, self.chambers, False)
        return self.kind(options)

    def told(self) -> Driven | None:
        """What the valves were told last, by the other end or by what left for it; None where no one knows."""
        return None if self.wire is None else self.wire.driven()

    @contextmanager
    def opened(self) -> Iterator[Device[Any]]:
        """A new one, open; closed in the end."""
        device = self.device()
        try:
            within(OPEN_LIMIT, "open", device.open)
            yield device
        finally:
            within(CLOSE_LIMIT, "close", device.close)

    @contextmanager
    def opened_and_heard(self) -> Iterator[Device[Any]]:
        """As `opened`, once something has come; vented in the end, whatever came of it: the board may never do so."""
        with self.opened() as device:
            try:
                self.first(device)
                yield device
            finally:
                for _ in range(ROUNDS):
                    with suppress(Exception):
                        self.call(device)

    def call(self, device: Device[Any], outlet: Outlet | None = None, timeout: float = TIMEOUT) -> Any:
        """One read or exchange that keeps to its time; vented without `outlet`."""
        what = "exchange" if self.valves else "read"
        there: Any = device
        begun = time.monotonic()
        if self.valves:
            sent = outlet if outlet is not None else Outlet.vented()
            found = within(timeout + HANGS, what, lambda: there.exchange(sent, timeout))
        else:
            found = within(timeout + HANGS, what, lambda: there.read(timeout))
        took = time.monotonic() - begun
        require(took <= timeout + MARGIN, f"{what} took {took:.3f} s at a timeout of {timeout:g} s")
        return found

    def lossy_call(self, device: Device[Any]) -> Any:
        """The same with nothing at the other end: DeviceError and OSError are in order, and give None."""
        try:
            return self.call(device)
        except (DeviceError, OSError):
            return None

    def first(self, device: Device[Any], limit: float = 3.0) -> Any:
        """What comes first within `limit` [s]."""
        until = time.monotonic() + limit
        while time.monotonic() < until:
            found = self.call(device)
            if found is not None:
                return found
        raise Failed(f"nothing came within {limit:g} s")

    def drain(self, device: Device[Any]) -> None:
        """Take what was under way when the device fell silent: it would end a call that is meant to wait."""
        until = time.monotonic() + 3.0
        while time.monotonic() < until and self.call(device) is not None:
            pass


def wanted(pressures: Array) -> Outlet:
    """Setpoints (4,) [Pa]."""
    return Outlet(time.monotonic_ns(), False, False, np.asarray(pressures, float), np.zeros(4))
