"""A thread for each device: opens it, talks to it, opens it again when it is lost, and counts what comes.

Nothing here is waited for by the loop: it reads one mailbox and writes another.
"""

import logging
import threading
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable
from itertools import pairwise
from typing import Any, Literal

import numpy as np

from controller.drivers.device import Angles, CaptureDevice, Device, DeviceError, Outlet, Reading, Sample, ValveDevice
from controller.drivers.inlet import Inlet
from controller.drivers.tracker import Tracker
from controller.schema.hardware import DriverStatus

log = logging.getLogger(__name__)

RETRY = 0.5
"""Pause before a lost device is opened again [s]."""
READ_TIMEOUT = 0.1
"""Longest wait for one frame [s]; also how soon a thread ends."""
SILENT = 0.25
"""Without a usable frame for so long, a device counts as silent [s]."""
OUTLET_OLD_NS = 50_000_000
"""Of a loop that made no command for so long, the valves get none: they vent [ns]."""
LATE = 200
"""Frames of which rate and latency are the median."""
IDLE_PERIOD = 0.01
"""Between two exchanges while nothing is driven [s]: no board's watchdog minds, and the machine rests."""
SHOWN = 20
"""Points of a frame that are shown."""
STAYS = 0.2
"""What a vented board says for longer than this is no leftover of what the vent ended [s]."""
ROUNDS = 3
"""Times that the vented command is sent before a board is let go."""

NewestOutlet = Callable[[], Outlet]


class DeviceThread(ABC):
    """Keeps one device open and its `DriverStatus` true."""

    role: Literal["motion_capture", "valves"]

    def __init__(self, device: Device[Any], driver: str) -> None:
        self.device, self._driver = device, driver
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"driver-{driver}", daemon=True)
        self._state: Literal["opening", "running", "silent", "lost"] = "opening"
        self._detail = ""
        self._frames = self._lost = self._refused = self._reconnects = 0
        self._number = -1
        self._arrivals: deque[tuple[int, int]] = deque(maxlen=LATE)
        """(arrival, capture) of late frames [ns]."""
        self._newest_seen: Sample | Angles | Reading | None = None

    def start(self) -> None:
        """Begin to open the device."""
        self._thread.start()

    def stop(self, timeout: float = 2.0) -> None:
        """End the thread and close the device; one that hangs for `timeout` [s] is left behind."""
        self._stopping.set()
        if self._thread.is_alive():
            self._thread.join(timeout)
        if self._thread.is_alive():
            log.error("driver %s does not end: left behind", self._driver)

    @property
    def ready(self) -> bool:
        """Whether usable frames come and the device obeys; what it only gives notice of hinders no one."""
        return self._state == "running" and 0.0 <= self._age() <= SILENT and not self._detail

    def status(self) -> DriverStatus:
        """How it fares now."""
        age, arrivals = self._age(), list(self._arrivals)
        apart = [b[0] - a[0] for a, b in pairwise(arrivals)]
        fresh = 0.0 <= age <= SILENT
        state = "silent" if self._state == "running" and not fresh else self._state
        known = self.device.clock != "arrival" and len(arrivals) > 0
        latency = float(np.median([came - taken for came, taken in arrivals])) * 1e-9 if known else -1.0
        return DriverStatus(
            role=self.role,
            driver=self._driver,
            device=self.device.name,
            state=state,
            detail=self._detail or ("nothing usable comes" if state == "silent" else self.device.notice),
            capabilities=self.device.capabilities,
            rate=1e9 / float(np.mean(apart)) if fresh and len(apart) > 0 and sum(apart) > 0 else 0.0,
            age=age,
            latency=latency,
            clock=self.device.clock,
            clock_offset=self.device.clock_offset,
            frames=self._frames,
            lost=self._lost,
            rejected=self.device.rejected + self._refused + self._strangers(),
            late=self.device.late,
            reconnects=self._reconnects,
            values=raw_values(self._newest_seen),
        )

    def _age(self) -> float:
        """Of the newest usable frame [s]; -1 before the first."""
        newest = self._arrivals[-1][0] if self._arrivals else 0
        return (time.monotonic_ns() - newest) * 1e-9 if newest else -1.0

    def _strangers(self) -> int:
        return 0

    def _run(self) -> None:
        """Open, talk, and open again; whatever a driver raises ends no thread."""
        while not self._stopping.is_set():
            try:
                self.device.open()
                self._state, self._detail, self._number = "running", "", -1
                self._talk()
            except Exception as error:
                self._lose(error)
            finally:
                self._close()
            if not self._stopping.wait(RETRY):
                self._reconnects += 1

    def _lose(self, error: Exception) -> None:
        known = isinstance(error, DeviceError | OSError)
        text = str(error) if known else f"the driver failed: {type(error).__name__}: {error}"
        if text != self._detail:
            log.error("%s lost: %s", self.device.name, text)
        self._state, self._detail = "lost", text

    def _close(self) -> None:
        try:
            self.device.close()
        except Exception as error:
            log.error("%s could not be closed: %s", self.device.name, error)

    @abstractmethod
    def _talk(self) -> None:
        """Until the end, or an error."""

    def _note(self, taken: bool, t_ns: int, number: int) -> None:
        """Count a frame captured at `t_ns`, that the loop took or not."""
        if not taken:
            self._refused += 1
            return
        if 0 <= self._number < number < self._number + 100_000:
            self._lost += number - self._number - 1
        self._number = number
        self._frames += 1
        self._arrivals.append((time.monotonic_ns(), t_ns))


class CaptureThread(DeviceThread):
    """From motion capture to the inlet."""

    role = "motion_capture"
    device: CaptureDevice[Any]

    def __init__(self, device: CaptureDevice[Any], driver: str, tracker: Tracker, inlet: Inlet) -> None:
        super().__init__(device, driver)
        self._tracker, self._inlet = tracker, inlet

    def _strangers(self) -> int:
        return self._tracker.strangers

    def _talk(self) -> None:
        while not self._stopping.is_set():
            seen = self.device.read(READ_TIMEOUT)
            if seen is not None:
                self._note(self._inlet.take_markers(seen.t_ns, self._tracker.markers(seen)), seen.t_ns, seen.number)
                self._newest_seen = seen


class ValveThread(DeviceThread):
    """From the loop's commands to the valves, and their pressures to the inlet."""

    role = "valves"
    device: ValveDevice[Any]

    def __init__(self, device: ValveDevice[Any], driver: str, newest: NewestOutlet, inlet: Inlet) -> None:
        super().__init__(device, driver)
        self._newest, self._inlet = newest, inlet
        self._said = "", 0.0
        """Why the board drives nothing, and since when it says so [s on the monotonic clock]."""

    def _talk(self) -> None:
        due = time.monotonic()
        while not self._stopping.is_set():
            outlet = self.allowed()
            self._exchange(outlet)
            period = max(self.device.period, IDLE_PERIOD if outlet.vent else 0.0)
            due = max(due + period, time.monotonic())
            time.sleep(max(0.0, due - time.monotonic()))
        for _ in range(ROUNDS):
            self.device.exchange(Outlet.vented(self._newest().cut), READ_TIMEOUT)

    def allowed(self) -> Outlet:
        """The loop's newest command, or to vent where that is old: a supply that was cut stays cut."""
        outlet = self._newest()
        return Outlet.vented(outlet.cut) if time.monotonic_ns() - outlet.t_ns > OUTLET_OLD_NS else outlet

    def _exchange(self, outlet: Outlet) -> None:
        reading = self.device.exchange(outlet, READ_TIMEOUT)
        if reading is None:
            return
        self._note(self._inlet.take_reading(reading), reading.t_ns, reading.number)
        self._newest_seen = reading
        self._detail = reading.stopped if not outlet.vent or self._stays(reading.stopped) else ""

    def _stays(self, stopped: str) -> bool:
        """Whether a board that is told to vent goes on saying why it would drive nothing, as with its stop pressed:
        what a vented command ends it says no longer.
        """
        now = time.monotonic()
        if stopped != self._said[0]:
            self._said = stopped, now
        return now - self._said[1] > STAYS


def finite(values: Any) -> list[float | None]:
    """Numbers as JSON has them: None for what is none."""
    return [float(value) if np.isfinite(value) else None for value in np.asarray(values, float).ravel()]


def raw_values(seen: Sample | Angles | Reading | None) -> dict[str, list[float | None]]:
    """What came, for the eye: points by name, angles, or pressures."""
    if seen is None:
        return {}
    if isinstance(seen, Reading):
        return {"pressures": finite(seen.pressures)}
    if isinstance(seen, Angles):
        return {"angles": finite(seen.angles)}
    labels = [*seen.labels, *[""] * (len(seen.points) - len(seen.labels))]
    return {labels[i] or f"#{i + 1}": finite(seen.points[i]) for i in range(min(len(seen.points), SHOWN))}
