"""Checks that hold for motion capture and valves alike."""

import threading
import time
from concurrent.futures import wait
from typing import Any

from controller.drivers.conformance.trial import (
    CLOSE_LIMIT,
    OPEN_LIMIT,
    OURS,
    Failed,
    NotShown,
    Trial,
    require,
    within,
)
from controller.drivers.device import DeviceError
from controller.system.thread import in_thread

REOPEN = 10.0
"""A device that is back must be found within so long [s]."""
RECORD = "--record, which pulls the cable between driver and device"


def touches_nothing_before_open(trial: Trial) -> str:
    """A device that was never opened has a name, and can be closed."""
    before = set(threading.enumerate())
    device = trial.device()
    require(isinstance(device.name, str) and device.name != "", "it has no name")
    within(CLOSE_LIMIT, "close before open", device.close)
    require(not _new_threads(before), "it begins a thread before it is opened")
    return device.name


def opens_and_closes_twice(trial: Trial) -> str:
    """Open, close, close, and all of it again; no thread stays behind."""
    before = set(threading.enumerate())
    device = trial.device()
    begun = time.monotonic()
    for _ in range(2):
        try:
            within(OPEN_LIMIT, "open", device.open)
            trial.first(device)
        finally:
            within(CLOSE_LIMIT, "close", device.close)
        within(CLOSE_LIMIT, "close", device.close)
    took = time.monotonic() - begun
    until = time.monotonic() + 1.0
    while _new_threads(before) and time.monotonic() < until:
        time.sleep(0.01)
    left = _new_threads(before)
    require(not left, f"it leaves a thread behind: {', '.join(thread.name for thread in left)}")
    return f"twice in {took:.2f} s"


def ends_when_closed(trial: Trial) -> str:
    """Close from another thread ends a call that waits: with an error of the device, or with None."""
    with trial.opened() as device:
        trial.first(device)
        if trial.wire is not None:
            trial.wire.silence()
            trial.drain(device)
        try:
            return _closed_while_waiting(trial, device)
        finally:
            if trial.wire is not None:
                trial.wire.plug()


def _closed_while_waiting(trial: Trial, device: Any) -> str:
    call = in_thread(OURS, lambda: trial.call(device, timeout=5.0))
    time.sleep(0.2)
    waited = not call.done()
    begun = time.monotonic()
    within(CLOSE_LIMIT, "close", device.close)
    require(bool(wait([call], CLOSE_LIMIT).done), f"a call that waits is not ended by close within {CLOSE_LIMIT:g} s")
    error = call.exception()
    known = isinstance(error, DeviceError | OSError | None)
    require(known, f"closed while a call waits, that raises {type(error).__name__}: {error}")
    if not waited and call.exception() is None and call.result() is not None:
        raise NotShown("the device answered, so that no call had to wait", RECORD)
    return f"after {1e3 * (time.monotonic() - begun):.0f} ms" if waited else "no call waits, with nothing to hear"


def survives_a_loss(trial: Trial) -> str:
    """With the device gone, calls keep to their time and raise DeviceError, OSError or nothing; then it comes back."""
    if trial.wire is None:
        raise NotShown("nothing here could be unplugged", f"{RECORD}, or your own hand under `tendril up`")
    device = trial.device()
    try:
        within(OPEN_LIMIT, "open", device.open)
        trial.first(device)
        trial.wire.unplug()
        for _ in range(8):
            trial.lossy_call(device)
        within(CLOSE_LIMIT, "close", device.close)
        _try_open(device)
        within(CLOSE_LIMIT, "close", device.close)
        trial.wire.plug()
        return f"back after {_back(trial, device):.2f} s"
    finally:
        trial.wire.plug()
        within(CLOSE_LIMIT, "close", device.close)


def _try_open(device: Any) -> bool:
    try:
        within(OPEN_LIMIT, "open of what is not there", device.open)
    except (DeviceError, OSError):
        return False
    return True


def _back(trial: Trial, device: Any) -> float:
    begun = time.monotonic()
    while time.monotonic() - begun < REOPEN:
        if _try_open(device):
            until = time.monotonic() + 1.0
            while time.monotonic() < until:
                if trial.lossy_call(device) is not None:
                    return time.monotonic() - begun
        within(CLOSE_LIMIT, "close", device.close)
        time.sleep(0.05)
    raise Failed(f"the device is back, and not found within {REOPEN:g} s")


def _new_threads(before: set[threading.Thread]) -> list[threading.Thread]:
    return [thread for thread in threading.enumerate() if thread not in before and not thread.name.startswith(OURS)]
