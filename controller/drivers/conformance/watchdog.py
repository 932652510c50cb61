"""Whether the device vents by itself when its host dies: no program on this machine can."""

import time
from typing import Any, NamedTuple

import numpy as np

from controller.arrays import Array
from controller.drivers.conformance.bench import Bench
from controller.drivers.conformance.trial import CLOSE_LIMIT, OPEN_LIMIT, NotShown, Trial, require, within
from controller.drivers.conformance.valves import driven, is_empty, released, settle, vent
from controller.drivers.device import DeviceError

LOST_LIMIT = 1.5
"""Longest from the last command until they vent by themselves [s]."""
LOW = np.full(4, 20e3)
"""What the chambers of a real board are left with, well above an empty one [Pa]."""
TRIES = 3
"""A machine that pauses may read too late to tell."""
LATER = "a rig process that is killed while you look at the gauges"


class Found(NamedTuple):
    """What the sensors said first, after a while without a host."""

    pressures: Array
    """(4,) [Pa]."""
    late: float
    """After that while, until they said it [s]."""


def vents_when_host_dies(trial: Trial) -> str:
    """With no command any more the device itself vents, whether its connection stays or is closed."""
    with driven(trial) as device:
        if trial.bench is not None and trial.bench.driven() is not None:
            return _by_the_bench(trial, trial.bench, device)
        settle(trial, device, LOW)
        empties = vent(trial, device)
        for _ in range(TRIES):
            found = _after_silence(trial, device)
            _require_empty(found, "with nothing closed")
            _require_empty(_after_close(trial, device), "closed and opened again")
            if found.late < 0.5 * empties:
                return f"within {LOST_LIMIT:g} s, with the connection open, and once it was closed"
    raise NotShown(
        f"chambers empty in {empties:.2f} s, and were read {found.late:.2f} s after the first command", LATER
    )


def _by_the_bench(trial: Trial, bench: Bench, device: Any) -> str:
    for _ in range(TRIES):
        settle(trial, device, LOW)
        if not _vented(bench):
            break
    require(not _vented(bench), "the chambers are full, and the valves are said to be vented")
    begun = time.monotonic()
    while (took := time.monotonic() - begun) < LOST_LIMIT:
        if _vented(bench):
            return f"after {1e3 * took:.0f} ms"
        time.sleep(0.002)
    require(False, f"the valves go on for more than {LOST_LIMIT:g} s")
    return ""


def _vented(bench: Bench) -> bool:
    told = bench.driven()
    return told is not None and told.vent


def _after_silence(trial: Trial, device: Any) -> Found:
    """Filled, then not spoken to: a host that hangs, or a cable that is cut, closes nothing and vents nothing."""
    released(trial, device)
    settle(trial, device, LOW)
    if trial.recorder is not None:
        trial.recorder.silence()  # nor does a thread of the driver's own speak
    time.sleep(LOST_LIMIT)
    if trial.recorder is not None:
        trial.recorder.plug()
    begun = time.monotonic()
    try:
        return Found(trial.first(device).pressures, time.monotonic() - begun)
    except (DeviceError, OSError):  # it hung up meanwhile
        return _reopened(trial, device)


def _after_close(trial: Trial, device: Any) -> Found:
    """Filled, then closed: a process that was killed leaves its connections closed."""
    released(trial, device)
    settle(trial, device, LOW)
    within(CLOSE_LIMIT, "close", device.close)
    time.sleep(LOST_LIMIT)
    return _reopened(trial, device)


def _reopened(trial: Trial, device: Any) -> Found:
    within(CLOSE_LIMIT, "close", device.close)
    begun = time.monotonic()
    within(OPEN_LIMIT, "open", device.open)
    return Found(trial.first(device).pressures, time.monotonic() - begun)


def _require_empty(found: Found, how: str) -> None:
    if not np.isfinite(found.pressures).all():
        raise NotShown(f"{how}, the sensors say {found.pressures} Pa", "sensors that all give a number")
    text = f"{how}, after {LOST_LIMIT:g} s without a command the chambers hold {np.round(found.pressures)} Pa"
    require(is_empty(found.pressures), f"{text}: nothing vents when this machine dies")
