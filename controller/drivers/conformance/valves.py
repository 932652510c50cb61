"""Checks of what leaves for the valves."""

import time
from typing import Any

import numpy as np

from controller.arrays import Array
from controller.drivers.conformance.trial import NotTried, Trial, require, wanted
from controller.drivers.device import DeviceError, Outlet

STEPS = np.array([10e3, 20e3, 30e3, 40e3])
"""Different in each chamber, so that a swap shows [Pa]."""
TOLERANCE = 4e3
"""By which a pressure may miss its setpoint [Pa]."""
SETTLE = 3.0
"""Longest until it is there [s]."""
EMPTY = 5e3
"""A vented chamber is below this [Pa]."""
VENT_LIMIT = 0.5
"""Longest from a command to vent until the valves know it [s]."""
LOST_LIMIT = 1.5
"""Longest from the last command until they vent by themselves [s]."""
SETPOINT_MOST, SETPOINT_LEAST = 1e6, -110e3
"""No driver passes on a setpoint outside this [Pa]."""
IMPOSSIBLE = (np.nan, np.inf, -np.inf, 1e12, -1e12, 1e300)


def follows_in_pascal(trial: Trial) -> str:
    """Each chamber comes to its own setpoint, as its own sensor says."""
    if not trial.drive:
        raise NotTried("--drive lets it command 10 to 40 kPa")
    with trial.opened() as device:
        trial.first(device)
        pressures, took = _settled(trial, device, STEPS)
        text = f"at setpoints of {STEPS / 1e3} kPa the sensors say {np.round(pressures, 1)} Pa after {SETTLE:g} s"
        require(took is not None, f"{text}: other units, or other chambers?")
        for _ in range(20):
            trial.call(device, Outlet.vented())
        return f"within {TOLERANCE / 1e3:g} kPa after {took:.2f} s"


def _settled(trial: Trial, device: Any, setpoints: Array) -> tuple[Array, float | None]:
    begun, pressures = time.monotonic(), np.full(4, np.nan)
    while (now := time.monotonic()) - begun < SETTLE:
        reading = trial.call(device, wanted(setpoints))
        if reading is not None:
            pressures = reading.pressures
            if bool((np.abs(pressures - setpoints) <= TOLERANCE).all()):
                return pressures, now - begun
        time.sleep(trial.kind.period)
    return pressures, None


def sends_nothing_impossible(trial: Trial) -> str:
    """What is not a number, or beyond every valve, is not sent; the driver raises DeviceError or sends less."""
    if not trial.drive:
        raise NotTried("--drive lets it command impossible setpoints")
    tried = 0
    with trial.opened() as device:
        trial.first(device)
        for value in IMPOSSIBLE:
            for where in (slice(0, 1), slice(0, 4)):
                outlet = wanted(np.zeros(4))
                outlet.pressures[where], outlet.openings[where] = value, value
                _send(trial, device, outlet)
                tried += 1
                _require_possible(trial, value)
        _send(trial, device, Outlet.vented())
    return f"{tried} commands" + ("" if trial.bench is not None else ": none made it raise; what left is not seen here")


def _send(trial: Trial, device: Any, outlet: Outlet) -> None:
    try:
        trial.call(device, outlet)
    except DeviceError:  # to refuse it is in order
        pass
    time.sleep(0.005)


def _require_possible(trial: Trial, value: float) -> None:
    driven = trial.bench.driven() if trial.bench is not None else None
    if driven is None:
        return
    pressures, openings = np.asarray(driven.pressures), np.asarray(driven.openings)
    require(bool(np.isfinite(pressures).all() and np.isfinite(openings).all()), f"a command of {value} leaves as it is")
    inside = pressures.max() <= SETPOINT_MOST and pressures.min() >= SETPOINT_LEAST
    require(bool(inside), f"a command of {value:g} Pa leaves as {pressures.max():g} Pa")
    require(bool((np.abs(openings) <= 1.0).all()), f"a command of {value:g} leaves as an opening of {openings.max():g}")
    if not np.isfinite(value):
        still = driven.vent or (not driven.raw and bool((np.abs(pressures) < EMPTY).all()))
        require(still, f"a command of {value} still drives the valves")


def vents_when_told(trial: Trial) -> str:
    """A vented command empties the chambers, also one that holds other numbers; so does a cut."""
    with trial.opened() as device:
        trial.first(device)
        said = ""
        for cut in (False, True):
            if trial.drive:
                _settled(trial, device, STEPS)
            outlet = Outlet.vented(cut)._replace(pressures=np.full(4, 40e3), openings=np.ones(4))
            took = _until_vented(trial, device, outlet)
            said = f"after {1e3 * took:.0f} ms"
    driven = trial.bench.driven() if trial.bench is not None else None
    if driven is not None and not driven.cut:
        return f"{said}; it does not cut the supply: a valve outside must"
    return said


def _until_vented(trial: Trial, device: Any, outlet: Outlet) -> float:
    begun = time.monotonic()
    limit = VENT_LIMIT if trial.bench is not None else SETTLE
    while True:
        reading = trial.call(device, outlet)
        driven = trial.bench.driven() if trial.bench is not None else None
        took = time.monotonic() - begun
        if driven is not None:
            if driven.vent or (not driven.raw and not np.any(driven.pressures)):
                return took
        elif reading is not None and bool((np.nan_to_num(reading.pressures) < EMPTY).all()):
            return took
        require(took < limit, f"a vented command is not obeyed within {limit:g} s")
        time.sleep(trial.kind.period)


def vents_when_host_dies(trial: Trial) -> str:
    """With no command any more, and nothing closed, the device itself vents."""
    if trial.bench is None:
        raise NotTried("no virtual peer: kill the rig process and look at the gauges")
    with trial.opened() as device:
        trial.first(device)
        _settled(trial, device, STEPS)
        begun = time.monotonic()
        while (took := time.monotonic() - begun) < LOST_LIMIT:
            driven = trial.bench.driven()
            if driven is None or driven.vent:
                return f"after {1e3 * took:.0f} ms"
            time.sleep(0.002)
        require(False, f"the valves go on for more than {LOST_LIMIT:g} s")
    return ""
