"""A lab's rig as a driver: motion capture and valves, each in a thread of its own, behind two mailboxes."""

import math

import numpy as np

from controller.arrays import Array
from controller.assembly.plant import build_hardware
from controller.drivers.device import Outlet
from controller.drivers.driver import Newest, NewestCommand, Post
from controller.drivers.inlet import Inlet
from controller.drivers.registry import capture_device, valve_device
from controller.drivers.threads import CaptureThread, DeviceThread, ValveThread
from controller.drivers.tracker import Tracker
from controller.kernels.plant.hardware import Hardware as HardwarePlant
from controller.schema.hardware import DriverStatus, Hardware
from controller.schema.parameters import SENSORS, RigParameters


class HardwareDriver:
    """Real devices. Raises ParameterError where the rig file asks for what there is not."""

    simulated = False

    def __init__(self, parameters: RigParameters, hardware: Hardware) -> None:
        self.plant: HardwarePlant = build_hardware(hardware.valves, parameters.controller.dt)
        self._hardware, self._length = hardware, parameters.actuator.length
        self._pressures_lost = parameters.limits.pressures_lost
        self._capture = capture_device(hardware.motion_capture)
        self._valves = valve_device(hardware.valves)
        self._threads: list[DeviceThread] = []

    def start(self, post: Post, newest: Newest, command: NewestCommand) -> None:
        """Begin to open the devices; the rig is there before they are."""
        inlet = Inlet(post)
        tracker = Tracker(self._hardware.motion_capture, self._length, lambda: expected(newest()))
        asked = self._hardware
        self._threads = [
            CaptureThread(self._capture, asked.motion_capture.driver, tracker, inlet),
            ValveThread(self._valves, asked.valves.driver, lambda: outlet(command()), inlet),
        ]
        for thread in self._threads:
            thread.start()

    def stop(self) -> None:
        """Vent, and end every thread."""
        for thread in self._threads:
            thread.stop()

    def status(self) -> tuple[DriverStatus, ...]:
        """How each fares now."""
        return tuple(thread.status() for thread in self._threads)

    def unready(self) -> str:
        """Why the rig must not be armed, as "valves: no such file: /dev/ttyACM0"; "" where it may.

        Answers that come late do not hinder it: they are used. Pressures so old that the watchdog would bite do.
        """
        return "; ".join(
            f"{one.role.replace('_', ' ')} ({one.driver}) {why}"
            for one, thread in zip(self.status(), self._threads, strict=True)
            if (why := self._too_old(one) if thread.ready else f"{one.state}{': ' if one.detail else ''}{one.detail}")
        )

    def _too_old(self, one: DriverStatus) -> str:
        """What is wrong with the age of pressures that come, in words; "" where it is not known, too."""
        if one.role != "valves" or one.latency < 0.0 or one.rate <= 0.0:
            return ""
        age = one.latency + 1.0 / one.rate
        if age <= self._pressures_lost:
            return ""
        lost = f"limits.pressures_lost = {1e3 * self._pressures_lost:g} ms"
        return f"gives pressures that are {1e3 * age:.0f} ms old before the next ones come; {lost}"


def expected(row: np.void | None) -> Array:
    """Where the observer of telemetry `row` has its sensors, (10,2) [m]; nan before the first."""
    if row is None:
        return np.full((SENSORS, 2), math.nan)
    return np.asarray(row["backbone"][2::2], float)


def outlet(record: np.void) -> Outlet:
    """The loop's record as a driver takes it."""
    return Outlet(
        t_ns=int(record["t_ns"]),
        vent=bool(record["vent"]),
        cut=bool(record["cut"]),
        pressures=np.array(record["pressures"]),
        openings=np.array(record["openings"]),
    )
