"""Devices in threads of their own: lost, found again, slow, wrong; and the one place where they meet the loop."""

import math
import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from controller.arrays import Array
from controller.drivers.device import CaptureDevice, DeviceError, Outlet, Reading, Sample, ValveDevice
from controller.drivers.inlet import NEVER, Inlet
from controller.drivers.threads import CaptureThread, ValveThread
from controller.drivers.tracker import Tracker
from controller.schema.hardware import MotionCapture
from controller.schema.layout import Model

REST = np.column_stack((0.025 * np.arange(1, 11), np.zeros(10)))


class Nothing(Model):
    """No options."""


class Script:
    """What a device does at each call, the last for ever."""

    def __init__(self, *acts: Callable[[], Any]) -> None:
        self.acts, self.calls = acts, 0

    def __call__(self) -> Any:
        act = self.acts[min(self.calls, len(self.acts) - 1)]
        self.calls += 1
        time.sleep(1e-3)
        return act()


class Camera(CaptureDevice[Nothing]):
    """Reads its script."""

    Options, clock, name = Nothing, "two-way", "a camera"  # type: ignore[assignment]

    def __init__(self, reads: Script, opens: Script | None = None) -> None:
        super().__init__(Nothing())
        self.reads, self.opens, self.closed = reads, opens or Script(lambda: None), 0

    def open(self) -> None:
        self.opens()

    def close(self) -> None:
        self.closed += 1

    def read(self, timeout: float) -> Sample | None:
        found: Sample | None = self.reads()
        return found


class Board(ValveDevice[Nothing]):
    """Keeps what it was told, and answers its script."""

    Options, name = Nothing, "a board"  # type: ignore[assignment]

    def __init__(self, answers: Script) -> None:
        super().__init__(Nothing(), (0, 1, 2, 3), raw=False)
        self.answers, self.told = answers, list[Outlet]()

    def open(self) -> None:
        pass

    def close(self) -> None:
        pass

    def exchange(self, outlet: Outlet, timeout: float) -> Reading | None:
        self.told.append(outlet)
        found: Reading | None = self.answers()
        return found


class Loop:
    """Keeps every record that is posted."""

    def __init__(self) -> None:
        self.records: list[np.ndarray] = []
        self.inlet = Inlet(lambda record: self.records.append(record.copy()))

    @property
    def newest(self) -> np.void:
        row: np.void = self.records[-1][0]
        return row


def seen(points: Array = REST) -> Sample:
    return Sample(time.monotonic_ns(), points)


def lost() -> None:
    raise DeviceError("the cable is out")


def reading(stopped: str = "") -> Reading:
    return Reading(time.monotonic_ns(), np.array([1e3, 2e3, 3e3, 4e3]), stopped)


def until(what: Callable[[], bool]) -> None:
    end = time.monotonic() + 20
    while not what():
        assert time.monotonic() < end
        time.sleep(2e-3)


def camera_thread(device: Camera, loop: Loop) -> CaptureThread:
    asked = MotionCapture(driver="natnet", rods=tuple(range(1, 11)))
    return CaptureThread(device, "natnet", Tracker(asked, 0.25, lambda: REST), loop.inlet)


def test_markers_and_pressures_reach_the_loop_as_one_record() -> None:
    loop = Loop()
    threads = [
        camera_thread(Camera(Script(seen)), loop),
        ValveThread(Board(Script(reading)), "serial", Outlet.vented, loop.inlet),
    ]
    for thread in threads:
        thread.start()
    until(lambda: all(thread.ready for thread in threads))
    until(lambda: loop.newest["pressures"][3] == 4e3 and loop.newest["t_ns"] > 0)
    for thread in threads:
        thread.stop()
    assert np.allclose(loop.newest["markers"], REST)
    camera, valves = (thread.status() for thread in threads)
    assert camera.frames > 0 and 0 <= camera.latency < 0.1 and camera.clock == "two-way"
    assert valves.latency == -1, "a clock that no one knows gives no latency"
    assert valves.values["pressures"] == [1e3, 2e3, 3e3, 4e3]


def test_a_device_that_is_lost_is_opened_again_and_closed_between() -> None:
    device, loop = Camera(Script(seen, lost, seen)), Loop()
    thread = camera_thread(device, loop)
    thread.start()
    until(lambda: thread.status().state == "lost")
    assert "the cable is out" in thread.status().detail
    until(lambda: thread.ready)
    assert device.closed == 1 and thread.status().reconnects == 1 and thread.status().detail == ""
    thread.stop()


@pytest.mark.parametrize("error", [ValueError("nonsense"), ZeroDivisionError(), OSError(5, "Input/output error")])
def test_whatever_a_driver_raises_it_is_opened_again(error: Exception) -> None:
    def fail() -> None:
        raise error

    thread = camera_thread(Camera(Script(seen), Script(fail, lambda: None)), Loop())
    thread.start()
    until(lambda: thread.ready)
    thread.stop()


def test_a_camera_without_frames_is_silent_and_not_ready() -> None:
    thread = camera_thread(Camera(Script(seen, lambda: None)), Loop())
    thread.start()
    until(lambda: thread.status().state == "silent")
    assert not thread.ready
    thread.stop()


def test_samples_of_the_future_and_of_the_past_never_reach_the_loop() -> None:
    loop, now = Loop(), time.monotonic_ns()
    assert loop.inlet.take_markers(now, REST)
    for t_ns in (now, now - 1, 0, time.monotonic_ns() + 10**9):
        assert not loop.inlet.take_markers(t_ns, 2 * REST)
    assert np.allclose(loop.newest["markers"], REST)


def test_pressures_of_a_board_that_does_not_obey_are_shown_and_do_not_count_as_fresh() -> None:
    loop = Loop()
    assert loop.newest["pressures_ns"] == NEVER
    first = reading()
    loop.inlet.take_reading(first)
    loop.inlet.take_reading(reading("its watchdog vented")._replace(pressures=np.zeros(4)))
    assert loop.newest["pressures_ns"] == first.t_ns
    assert not loop.newest["pressures"].any()


def test_the_valves_are_told_to_vent_by_a_loop_that_no_longer_commands() -> None:
    commanded = Outlet(time.monotonic_ns(), False, False, np.full(4, 5e4), np.zeros(4))
    board = Board(Script(reading))
    thread = ValveThread(board, "serial", lambda: commanded, Loop().inlet)
    thread.start()
    until(lambda: len(board.told) > 100)
    thread.stop()
    driven = [outlet for outlet in board.told if not outlet.vent]
    assert driven and board.told[-1].vent
    assert all(outlet.vent for outlet in board.told[len(driven) :]), "once old it is never driven again"


def test_the_last_that_the_valves_hear_is_to_vent() -> None:
    def fresh() -> Outlet:
        return Outlet(time.monotonic_ns(), False, False, np.full(4, 5e4), np.zeros(4))

    board = Board(Script(reading))
    thread = ValveThread(board, "serial", fresh, Loop().inlet)
    thread.start()
    until(lambda: len(board.told) > 5)
    thread.stop()
    assert not board.told[0].vent and board.told[-1].vent


def test_a_driver_that_hangs_for_ever_keeps_nobody() -> None:
    hung = threading.Event()
    thread = camera_thread(Camera(Script(lambda: hung.wait(30.0) and None)), Loop())
    thread.start()
    thread.stop(timeout=0.1)
    hung.set()


def test_frames_that_the_device_numbered_and_that_did_not_come_are_counted() -> None:
    numbers = iter([5, 6, 9, 10, 3, 4])

    def numbered() -> Sample | None:
        number = next(numbers, None)
        return None if number is None else seen()._replace(number=number)

    thread = camera_thread(Camera(Script(numbered)), Loop())
    thread.start()
    until(lambda: thread.status().frames == 6)
    thread.stop()
    assert thread.status().lost == 2, "a device that began again has lost nothing"


def test_numbers_that_are_none_are_shown_as_none() -> None:
    points = REST.copy()
    points[3] = math.nan
    thread = camera_thread(Camera(Script(lambda: seen(points))), Loop())
    thread.start()
    until(lambda: thread.status().frames > 0)
    thread.stop()
    assert thread.status().values["#4"] == [None, None]
