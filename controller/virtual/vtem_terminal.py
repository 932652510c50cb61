"""What the registers of a CPX terminal with a VTEM and a digital output module do (docs/modbus.md)."""

import threading

import numpy as np

from controller.drivers.valves.modbus.vtem import (
    ACKNOWLEDGE,
    BOTH,
    CONTROL,
    END,
    FAIL_SAFE,
    FAILED,
    NOT_READY,
    PRESSURE_APP,
    READY,
    RUNNING,
    WATCHDOG,
    WRITE,
)
from controller.virtual.peers import Drive, ReadPressures, TakeDrive

OUTPUTS, INPUTS = 40001, 45392
SLOTS, CHANNELS = 8, 16
FIRST_OUT, FIRST_IN = OUTPUTS + 2, INPUTS + 3
"""Of slot 0: two registers of the bus node are before it among the outputs, three among the inputs."""
DUMP = FIRST_OUT + 3 * SLOTS
"""The digital output module behind the VTEM: bit 0 holds the dump valve shut."""
OUTPUT_WORDS = DUMP - OUTPUTS + 1
START = 0.05
"""From command to running app [s]."""
MBAR_MIN, MBAR_MAX = -900, 7000
"""Setpoints that the motion app follows."""

__all__ = ["DUMP", "INPUTS", "OUTPUTS", "OUTPUT_WORDS", "WATCHDOG", "VtemTerminal"]


class VtemTerminal:
    """Registers in and out, its watchdog, and what of it reaches the plant."""

    def __init__(self, read_pressures: ReadPressures, take_drive: TakeDrive) -> None:
        self._read, self._take = read_pressures, take_drive
        self._lock = threading.Lock()
        self._out = [0] * OUTPUT_WORDS
        self._watchdog = 0
        self._host = False
        self._heard = 0.0
        self._started: list[float | None] = [None] * SLOTS
        """Since when each slot was told to run the app."""
        self._state = [READY] * SLOTS
        self.fail_safe = 0
        """The system parameter: 0 resets outputs when the host is lost, 1 holds them."""
        self.hold_air = True
        """Whether an inactive valve is shut, which holds its air; else it exhausts."""

    def fail(self, slot: int) -> None:
        """A valve breaks; it is well again, and unacknowledged, after `mend`."""
        with self._lock:
            self._state[slot], self._started[slot] = FAILED, None
            self._drive(0.0)

    def mend(self, slot: int) -> None:
        """The failure is over, and waits to be acknowledged."""
        with self._lock:
            self._state[slot] = NOT_READY

    def heard(self, now: float) -> None:
        """A request came at `now` [s]."""
        with self._lock:
            self._host, self._heard = True, now

    def left(self, now: float) -> float | None:
        """Until the watchdog bites, if no one asks any more [s]; None: it will not."""
        with self._lock:
            bites = self._host and self._watchdog > 0
            return max(0.0, self._heard + self._watchdog * 1e-3 - now) + 1e-3 if bites else None

    def reset(self) -> None:
        """Its power was gone for a moment: the watchdog's time is the terminal's own again, none."""
        with self._lock:
            self._watchdog, self.fail_safe = 0, 0
            self._expire(0.0)

    def look(self, now: float) -> None:
        """Has the watchdog bitten?"""
        with self._lock:
            if self._watchdog and self._host and now - self._heard > self._watchdog * 1e-3:
                self._expire(now)
            elif self._host:
                self._drive(now)

    def write(self, address: int, values: list[int], now: float) -> None:
        """Outputs, or the watchdog's time."""
        with self._lock:
            self._host, self._heard = True, now
            if address == WATCHDOG:
                self._watchdog = values[0]
                return
            for i, value in enumerate(values):
                if 0 <= address + i - OUTPUTS < OUTPUT_WORDS:
                    self._out[address + i - OUTPUTS] = value
            self._obey(now)
            self._drive(now)

    def registers(self, now: float) -> dict[int, int]:
        """Every register that can be read, as it is now."""
        with self._lock:
            mbar = np.clip(np.rint(np.nan_to_num(self._read() / 100.0, nan=32767.0)), -32768, 32767)
            found = {WATCHDOG: self._watchdog} | dict(enumerate(self._out, OUTPUTS)) | self._parameter()
            for slot in range(SLOTS):
                mode, state = self._mode(slot, now)
                found[FIRST_IN + 3 * slot] = mode | state << 6
                for half in (0, 1):
                    found[FIRST_IN + 3 * slot + 1 + half] = int(mbar[2 * slot + half]) & 0xFFFF
            return found

    def _parameter(self) -> dict[int, int]:
        """Answer of the interface by which parameters are read and written."""
        asked = self._out[0]
        if not asked & CONTROL or asked & 0x1FFF != FAIL_SAFE:
            return {INPUTS: 0, INPUTS + 1: 0}
        return {INPUTS: asked, INPUTS + 1: self.fail_safe}

    def _obey(self, now: float) -> None:
        if self._out[0] == CONTROL | WRITE | FAIL_SAFE:
            self.fail_safe = self._out[1] & 3
        for slot in range(SLOTS):
            command = self._out[2 + 3 * slot]
            if command & 0x3F == ACKNOWLEDGE and self._state[slot] == NOT_READY:
                self._state[slot] = READY
            runs = command == PRESSURE_APP | BOTH and self._state[slot] == READY
            self._started[slot] = (self._started[slot] or now) if runs else None

    def _mode(self, slot: int, now: float) -> tuple[int, int]:
        since = self._started[slot]
        if self._state[slot] == READY and since is not None and now - since >= START:
            return PRESSURE_APP, RUNNING
        return END, self._state[slot]

    def _expire(self, now: float) -> None:
        self._host = False
        if self.fail_safe == 0:
            self._out = [0] * OUTPUT_WORDS
            self._started = [None] * SLOTS
        self._drive(now)

    def _drive(self, now: float) -> None:
        pressures = np.zeros(CHANNELS)
        for channel in range(CHANNELS):
            word = self._out[3 + 3 * (channel // 2) + channel % 2]
            pressures[channel] = np.clip(word - 65536 if word >= 32768 else word, MBAR_MIN, MBAR_MAX) * 100.0
        asked = [slot for slot in range(SLOTS) if self._out[2 + 3 * slot]]
        runs = bool(asked) and all(self._mode(slot, now)[1] == RUNNING for slot in asked)
        dumped = not self._out[DUMP - OUTPUTS] & 1
        self._take(
            Drive(
                pressures=pressures if runs else np.zeros(CHANNELS),
                openings=np.zeros(CHANNELS) if self.hold_air else np.full(CHANNELS, -1.0),
                raw=not runs,
                vent=dumped,
                cut=dumped,
            )
        )
