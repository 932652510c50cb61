"""Checks of what the valves do when they are told to."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from controller.arrays import Array
from controller.drivers.conformance.trial import NotShown, Trial, require, wanted
from controller.drivers.device import Outlet, Reading

STEPS = np.array([10e3, 20e3, 30e3, 40e3])
"""Different in each chamber, so that a swap shows [Pa]."""
TOLERANCE = 4e3
"""By which a pressure may miss its setpoint [Pa]."""
SETTLE = 3.0
"""Longest until it is there [s]."""
EMPTY = 5e3
"""A vented chamber is within this of the atmosphere [Pa]."""
VENT_LIMIT = 0.5
"""Longest from a command to vent until the valves know it [s]."""
DRIVE = "--drive, with no one near the actuator"


def follows_setpoints(trial: Trial) -> str:
    """Each chamber comes to its own setpoint, as its own sensor says."""
    with driven(trial) as device:
        took = settle(trial, device, STEPS)
        vent(trial, device)
        return f"within {TOLERANCE / 1e3:g} kPa after {took:.2f} s"


def speaks_pascal(trial: Trial) -> str:
    """What the valves are told is what was asked for, in pascal, at each channel: no sensor of its own says so."""
    if trial.bench is None and (trial.recorder is None or not trial.recorder.decodes):
        raise NotShown("setpoints and sensors may be wrong alike", "a gauge at a chamber, --record with --decode")
    with driven(trial) as device:
        found = _until_told(trial, device)
        vent(trial, device)
    text = f"at setpoints of {STEPS / 1e3} kPa the valves are told {np.round(found, 1)} Pa"
    require(_near(found, STEPS), f"{text}: other units, or other chambers?")
    return "told as asked"


def _until_told(trial: Trial, device: Any) -> Array:
    """Setpoints of the chambers (4,) [Pa] as the valves have them: right ones within `VENT_LIMIT`, or the newest."""
    begun, found = time.monotonic(), np.full(4, np.nan)
    while not _near(found, STEPS) and time.monotonic() - begun < VENT_LIMIT:
        trial.call(device, wanted(STEPS))
        told = trial.told()
        if told is None:
            raise NotShown("the other end does not say what it was told", "a peer whose `driven` does")
        found = np.full(4, np.nan) if told.raw else np.asarray(told.pressures, float)[list(trial.chambers)]
        time.sleep(trial.kind.period)
    return found


def vents_when_told(trial: Trial) -> str:
    """A vented command empties the chambers, also one that holds other numbers; so does a cut."""
    with driven(trial) as device:
        for cut in (False, True):
            settle(trial, device, STEPS)
            outlet = Outlet.vented(cut)._replace(pressures=np.full(4, 40e3), openings=np.ones(4))
            took = _until_vented(trial, device, outlet)
        told = trial.told()
    said = f"after {1e3 * took:.0f} ms"
    if told is None:
        return f"{said}; whether a cut shuts the supply is not seen here: look at its gauge"
    return said if told.cut else f"{said}; it does not cut the supply: a valve outside must"


def driven(trial: Trial) -> Any:
    """As `trial.opened`, of a device that may be driven, and has answered; NotShown where it may not."""
    if not trial.drive:
        raise NotShown("nothing was driven, and nothing filled", DRIVE)
    return trial.opened_and_heard()


def settle(trial: Trial, device: Any, setpoints: Array) -> float:
    """Drive the chambers to `setpoints` (4,) [Pa]; how long that took [s]. Failed where they do not come there."""
    pressures, took = until(trial, device, wanted(setpoints), lambda found: _near(found.pressures, setpoints), SETTLE)
    text = f"at setpoints of {setpoints / 1e3} kPa the sensors say {np.round(pressures, 1)} Pa after {SETTLE:g} s"
    require(took is not None, f"{text}: other units, or other chambers?")
    assert took is not None
    return took


def vent(trial: Trial, device: Any) -> float:
    """Until the sensors say that the chambers are empty [s]; Failed where they never do."""
    pressures, took = until(trial, device, Outlet.vented(), lambda found: is_empty(found.pressures), SETTLE)
    require(took is not None, f"vented for {SETTLE:g} s, the sensors say {np.round(pressures, 1)} Pa")
    assert took is not None
    return took


def released(trial: Trial, device: Any) -> None:
    """Vent until the board obeys again, which its watchdog stopped; Failed where it never does."""
    _, took = until(trial, device, Outlet.vented(), lambda found: not found.stopped, SETTLE)
    require(took is not None, f"a board that vented by itself obeys no more after {SETTLE:g} s of vented commands")


def until(
    trial: Trial, device: Any, outlet: Outlet, there: Callable[[Reading], bool], limit: float
) -> tuple[Array, float | None]:
    """Command `outlet` until a reading is `there`: the newest pressures (4,) [Pa], and when, if within `limit` [s]."""
    begun, pressures = time.monotonic(), np.full(4, np.nan)
    while (now := time.monotonic()) - begun < limit:
        reading: Reading | None = trial.call(device, outlet)
        if reading is not None:
            pressures = reading.pressures
            if there(reading):
                return pressures, now - begun
        time.sleep(trial.kind.period)
    return pressures, None


def is_empty(pressures: Array) -> bool:
    """Whether every sensor (4,) says so: one that is broken, and says nan, says nothing."""
    return bool((np.abs(pressures) < EMPTY).all())


def _near(pressures: Array, setpoints: Array) -> bool:
    return bool((np.abs(pressures - setpoints) <= TOLERANCE).all())


def _until_vented(trial: Trial, device: Any, outlet: Outlet) -> float:
    """How long until the valves know it, or where no one can tell, until the sensors say that it is so [s]."""
    if trial.bench is None or trial.bench.driven() is None:
        pressures, took = until(trial, device, outlet, lambda found: is_empty(found.pressures), SETTLE)
        require(took is not None, f"vented for {SETTLE:g} s, the sensors say {np.round(pressures, 1)} Pa")
        assert took is not None
        return took
    begun = time.monotonic()
    while True:
        trial.call(device, outlet)
        told, took = trial.bench.driven(), time.monotonic() - begun
        if told is not None and (told.vent or (not told.raw and not np.any(told.pressures))):
            return took
        require(took < VENT_LIMIT, f"a vented command is not obeyed within {VENT_LIMIT:g} s")
        time.sleep(trial.kind.period)
