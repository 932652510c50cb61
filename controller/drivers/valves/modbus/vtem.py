"""Festo's Motion Terminal VTEM in a CPX terminal: commands, states and the start of a motion app (docs/modbus.md)."""

import time
from typing import NamedTuple

from controller.drivers.device import DeviceError
from controller.drivers.valves.modbus.registers import SLOT_WORDS, Slot
from controller.drivers.valves.modbus.wire import Refused, Wire

PRESSURE_APP = 3
"""Proportional pressure regulation, -0.9 to 7 bar, each of a valve's two ports for itself."""
END, ACKNOWLEDGE = 61, 62
"""Valve modes that end an app and acknowledge errors."""
BOTH, ONE = 3 << 6, 1 << 6
"""Application control: regulate both ports; what goes with an acknowledgement."""
NOT_READY, READY, RUNNING, FAILED = range(4)
STATES = ("is not ready", "is ready, its app does not run", "runs", "has failed")
POLL_S = 0.02
"""Pause between two looks at a slot that starts [s]."""

WATCHDOG = 46100
"""Takes the CPX terminal's Modbus timeout [ms]."""
FAIL_SAFE = 4402
"""Function number of the system parameter, bits 0 and 1: 0 resets outputs when communication fails, 1 holds them."""
UNGUARDED = (
    "chambers would keep their pressure when the host is lost: look in the device's manual for its register and times "
    "(docs/modbus.md)"
)
"""What follows for a device whose watchdog cannot be set. To go without is no remedy, so it is not offered here."""
CONTROL, WRITE = 1 << 15, 1 << 13
"""Bits of the interface by which a CPX terminal's parameters are read and written."""


class Status(NamedTuple):
    """Of one slot."""

    mode: int
    state: int
    app_state: int

    @property
    def regulates(self) -> bool:
        """Whether the pressure app runs."""
        return self.mode == PRESSURE_APP and self.state == RUNNING


def status_of(word: int) -> Status:
    """A slot's status register: mode in bits 0 to 5, state in 6 and 7, the app's own in 8 to 15."""
    return Status(word & 0x3F, word >> 6 & 3, word >> 8)


def command_of(status: Status, vented: bool) -> int:
    """What a slot is told: run the app. While vented, a failure that is over is acknowledged."""
    return ACKNOWLEDGE | ONE if vented and status.state in (NOT_READY, FAILED) else PRESSURE_APP | BOTH


def complaint(slots: tuple[Slot, ...], words: dict[int, int]) -> str:
    """Why a slot does not regulate, for an operator; "" if all do."""
    for slot in slots:
        status = status_of(words[slot.status])
        if not status.regulates:
            return f"VTEM slot {slot.number} {_said(status)}"
    return ""


def _said(status: Status) -> str:
    if status.state == RUNNING:
        return f"runs motion app {status.mode}, not {PRESSURE_APP}"
    return f"{STATES[status.state]} (mode {status.mode}, app state 0x{status.app_state:02x})"


def start(wire: Wire, slots: tuple[Slot, ...], within: float, timeout: float) -> None:
    """Have every slot regulate pressures, at 0; DeviceError if one does not within `within` [s]."""
    until = time.monotonic() + within
    for slot in slots:
        while True:
            status = _status(wire, slot, timeout)
            _tell(wire, slot, command_of(status, vented=True), timeout)
            if status.regulates:
                break
            if time.monotonic() > until:
                raise DeviceError(f"VTEM slot {slot.number} {_said(status)} after {within:g} s")
            time.sleep(POLL_S)


def _status(wire: Wire, slot: Slot, timeout: float) -> Status:
    words = wire.read(slot.status, 1, timeout)
    if words is None:
        raise DeviceError(f"no answer when asked for the status of VTEM slot {slot.number}")
    return status_of(words[0])


def _tell(wire: Wire, slot: Slot, command: int, timeout: float) -> None:
    if not wire.write(slot.command, [command, *[0] * (SLOT_WORDS - 1)], timeout):
        raise DeviceError(f"no answer when VTEM slot {slot.number} was told to start")


def set_watchdog(wire: Wire, register: int, seconds: float, timeout: float) -> None:
    """Have the device reset its outputs after `seconds` without a request; DeviceError if it does not take it."""
    wanted = round(seconds * 1000)
    try:
        found = wire.read(register, 1, timeout) if wire.write(register, [wanted], timeout) else None
    except Refused as error:
        raise DeviceError(f"watchdog register {register}: {error}; {UNGUARDED}") from error
    if found is None:
        raise DeviceError(
            f"no answer when its watchdog was set (register {register}) within {timeout:g} s; whether it has one is "
            "not known: look at the device and its cable, and try again"
        )
    if found != [wanted]:
        raise DeviceError(f"watchdog register {register} keeps {found[0]} ms, not {wanted} ms; {UNGUARDED}")


def require_fail_safe(wire: Wire, out: int, into: int, change: bool, timeout: float) -> None:
    """Of a CPX terminal whose first output and input registers are given: it resets outputs when its host is lost.

    With `change` it is set to, else DeviceError says what to set.
    """
    found = _parameter(wire, out, into, timeout)
    if found & 3 and change:
        if not wire.write(out + 1, [found & ~3], timeout):
            raise DeviceError("no answer when the CPX terminal's fail safe was set")
        _request(wire, out, into, CONTROL | WRITE | FAIL_SAFE, timeout)
        found = _parameter(wire, out, into, timeout)
    if found & 3:
        raise DeviceError(
            "the CPX terminal keeps its outputs when its host is lost: set its system parameter Fail safe to "
            '"reset outputs", or fail_safe = "set"'
        )


def _parameter(wire: Wire, out: int, into: int, timeout: float) -> int:
    _request(wire, out, into, CONTROL | FAIL_SAFE, timeout)
    words = wire.read(into + 1, 1, timeout)
    if words is None:
        raise DeviceError("no answer when asked for the CPX terminal's fail safe")
    return words[0]


def _request(wire: Wire, out: int, into: int, command: int, timeout: float) -> None:
    until = time.monotonic() + timeout
    for word in (0, command):  # a request is taken when its bit rises
        if not wire.write(out, [word], timeout):
            raise DeviceError("no answer when asked for a parameter of the CPX terminal")
    while True:
        words = wire.read(into, 1, timeout)
        if words and words[0] & CONTROL:
            return
        if time.monotonic() > until:
            raise DeviceError(
                f"the CPX terminal does not tell its fail safe within {timeout:g} s; whether it resets its outputs "
                "when its host is lost is not known: look at it with Festo's tool (docs/modbus.md)"
            )
