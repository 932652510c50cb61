"""Whether a command that cannot be meant leaves for the valves: nan, infinity, or more than any valve holds."""

import math
import re
import struct
import time
from collections.abc import Iterator
from typing import Any

import numpy as np

from controller.drivers.conformance.bench import Driven
from controller.drivers.conformance.recorder import Recorder
from controller.drivers.conformance.trial import NotShown, Trial, require, wanted
from controller.drivers.device import DeviceError, Outlet

SETPOINT_MOST, SETPOINT_LEAST = 1e6, -110e3
"""No driver passes on a setpoint outside this [Pa]."""
STILL = 5e3
"""A setpoint below this drives nothing [Pa]."""
IMPOSSIBLE = (np.nan, np.inf, -np.inf, 1e12, -1e12, 1e300)
WHERE = (slice(0, 1), slice(0, 4))
"""One chamber, and all."""
UNITS = (1.0, 1e-2, 1e-3, 1e-5, 1.0 / 6894.757)
"""Pa, mbar, kPa, bar and psi: how a setpoint may stand in what leaves."""
NUMBER = re.compile(rb"(?<![a-z])[-+]?(?:nan|inf(?:inity)?)(?![a-z])|[-+]?\d+\.?\d*(?:e[-+]?\d+)?", re.IGNORECASE)
"""As text has it."""
LEAVES_S, QUIET_S = 0.3, 0.05
"""Longest until a command has left; so long after its last byte it has left whole [s]."""
SHOWN = 60
"""Bytes of a command that are told."""


def sends_nothing_impossible(trial: Trial) -> str:
    """What is not a number, or beyond every valve, is not sent; the driver raises DeviceError or sends less.

    A real device is given nothing of the kind: a recorder holds it back.
    """
    if trial.recorder is not None:
        return _held_back(trial, trial.recorder)
    if trial.bench is None:
        raise NotShown(
            "what leaves is not seen here, and a board is given no nan to try it",
            "--record, which keeps what leaves and holds it back",
        )
    tried = 0
    with trial.opened() as device:
        trial.first(device)
        for value, where in _commands():
            _send(trial, device, value, where)
            time.sleep(0.005)
            _require_possible(trial.told(), value)
            tried += 1
        trial.call(device)
    return f"{tried} commands"


def _commands() -> Iterator[tuple[float, slice]]:
    return ((value, where) for value in IMPOSSIBLE for where in WHERE)


def _send(trial: Trial, device: Any, value: float, where: slice) -> bool:
    """Whether the driver took it: to refuse it is in order."""
    outlet: Outlet = wanted(np.zeros(4))
    outlet.pressures[where], outlet.openings[where] = value, value
    try:
        trial.call(device, outlet)
    except DeviceError:
        return False
    return True


def _require_possible(told: Driven | None, value: float) -> None:
    """Of what the valves were told, or hold: NotShown where that is not known."""
    if told is None:
        raise NotShown("what the valves were told is not known", "a peer or a --decode that says it")
    pressures, openings = np.asarray(told.pressures), np.asarray(told.openings)
    require(bool(np.isfinite(pressures).all() and np.isfinite(openings).all()), f"a command of {value} leaves as it is")
    inside = pressures.max() <= SETPOINT_MOST and pressures.min() >= SETPOINT_LEAST
    require(bool(inside), f"a command of {value:g} Pa leaves as {pressures.max():g} Pa")
    require(bool((np.abs(openings) <= 1.0).all()), f"a command of {value:g} leaves as an opening of {openings.max():g}")
    if not np.isfinite(value):
        still = told.vent or (not told.raw and bool((np.abs(pressures) < STILL).all()))
        require(still, f"a command of {value} still drives the valves")


def _held_back(trial: Trial, recorder: Recorder) -> str:
    """Each command by a device of its own: one that gets no answers may send nothing more."""
    tried = 0
    for value, where in _commands():
        try:
            with trial.opened() as device:
                trial.first(device)
                recorder.hold()
                took = _send(trial, device, value, where)
                left = _left(recorder)
        finally:
            recorder.plug()
        require(not _stands_in(value, left), f"a command of {value} leaves as it is: {left[:SHOWN]!r}")
        if left and recorder.decodes:
            _require_possible(recorder.driven(), value)
        if took and not left:
            raise NotShown(f"a command of {value} was taken, and nothing left", "a driver that sends each command")
        tried += 1
    if not recorder.decodes:
        raise NotShown(
            f"of {tried} commands none left as it was; what the bytes mean is not known here",
            "--decode, or a peer of your own",
        )
    return f"{tried} commands, held back before they reached the device"


def _left(recorder: Recorder) -> bytes:
    """What left, once nothing more does."""
    begun, found = time.monotonic(), b""
    while time.monotonic() - begun < LEAVES_S:
        time.sleep(QUIET_S)
        newest = recorder.left()
        if newest and newest == found:
            break
        found = newest
    return found


def _stands_in(value: float, sent: bytes) -> bool:
    """Whether `value` is to be read in what was sent, in a unit of pressure: as text, or as memory has it."""
    likely = [value * unit for unit in UNITS]
    written = [_number(text) for text in NUMBER.findall(sent)]
    if any(_same(one, other) for one in written for other in likely):
        return True
    return any(packed in sent for one in likely for packed in _packed(one))


def _number(text: bytes) -> float:
    return float(text.decode())


def _same(one: float, other: float) -> bool:
    return (math.isnan(one) and math.isnan(other)) or math.isclose(one, other, rel_tol=1e-3)


def _packed(value: float) -> Iterator[bytes]:
    for form in ("<f", ">f", "<d", ">d", "<i", ">i", "<q", ">q"):
        try:
            yield struct.pack(form, value if form[1] in "fd" else int(value))
        except (OverflowError, ValueError, struct.error):  # it does not fit
            continue
    if math.isnan(value):
        yield from (struct.pack(form, -value) for form in ("<f", ">f", "<d", ">d"))
