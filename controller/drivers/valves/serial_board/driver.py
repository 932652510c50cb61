"""A board with valves and pressure sensors at a serial line: `firmware/`, or any that speaks docs/serial.md."""

import logging
import math
import os
import select
import time
from typing import Annotated

import numpy as np
import serial
from pydantic import Field as Bounds

from controller.drivers.clocks import TwoWayClock
from controller.drivers.device import DeviceError, Outlet, Reading, ValveDevice
from controller.drivers.valves.serial_board import frames
from controller.drivers.valves.serial_board.frames import HelloReply, State
from controller.drivers.valves.serial_board.pending import Match, Pending
from controller.schema.layout import Model
from controller.schema.layout import Quantity as Q

log = logging.getLogger(__name__)

AT_ONCE = 4096
"""Bytes that are read in one go at most."""
GONE = select.POLLHUP | select.POLLERR | select.POLLNVAL


class Line:
    """pyserial opens and sets up the port; its own reads set the whole port up again for each new timeout."""

    def __init__(self, path: str, baud: int) -> None:
        """Open it; raises OSError where there is none, it is not ours, or another program has it."""
        self._port = serial.Serial(path, baud, timeout=0, write_timeout=0, exclusive=True)
        self._hurry()
        self._file = self._port.fileno()
        self._poll = select.poll()
        self._poll.register(self._file, select.POLLIN)

    def _hurry(self) -> None:
        """Have the system pass on what comes at once: an FTDI adapter else holds it back for 16 ms."""
        try:
            self._port.set_low_latency_mode(True)
        except (ValueError, NotImplementedError) as error:  # USB of the board's own has none, and holds nothing back
            log.info("%s has no low-latency mode: %s", self._port.name, error)

    def write(self, data: bytes) -> bool:
        """Send `data`; False where the line takes no more now, and part of it may be lost. OSError: it is gone."""
        try:
            return os.write(self._file, data) == len(data)
        except BlockingIOError:
            return False

    def read(self, deadline: float) -> bytes:
        """What has come, b"" if nothing has by `deadline` on the monotonic clock [s]; DeviceError: it is gone."""
        ready = self._poll.poll(max(0.0, deadline - time.monotonic()) * 1e3)
        if not ready:
            return b""
        try:
            data = os.read(self._file, AT_ONCE)
        except BlockingIOError:
            data = b""
        if not data and ready[0][1]:
            raise DeviceError("the line is gone: is its cable still plugged in?")
        return data

    def forget(self) -> None:
        """Throw away what has come and not been read."""
        self._port.reset_input_buffer()

    def close(self) -> None:
        """Let go of the port."""
        try:
            self._port.close()
        except OSError:
            pass  # of a line that is gone there is nothing left


ASK_AGAIN = 0.1
"""Pause between two greetings [s]: an Arduino starts again when its port is opened, and hears none for a second."""
CLOCK_EVERY_NS = 100_000_000
"""The quickest answer of so long is one for the clock [ns]."""
WRAP = 2**32


class SerialOptions(Model):
    """Where the board is."""

    port: Annotated[str, Bounds(min_length=1, max_length=200)]
    """Path, as "/dev/serial/by-id/usb-Arduino...": names there stay when others are plugged in."""
    baud: Annotated[int, Bounds(ge=9600, le=12_000_000), Q("1/s")] = 1_000_000
    """Of a real UART; a board with USB of its own ignores it."""
    timeout: Annotated[float, Bounds(ge=0.002, le=0.2), Q("s")] = 0.01
    """An answer after more is late: used, counted and said. Without one the next command is sent, after half the
    board's watchdog at the latest."""
    hello_timeout: Annotated[float, Bounds(ge=0.1, le=20.0), Q("s")] = 4.0
    """A board that says nothing for so long after its port was opened is none."""


class SerialBoard(ValveDevice[SerialOptions]):
    """One question, one answer, 500 times a second."""

    Options = SerialOptions
    capabilities = ("two-way clock", "setpoints", "raw openings", "own watchdog", "own limits", "supply cut")
    clock = "two-way"
    period = 0.002

    board: HelloReply | None = None
    """What the board said it is; None while it is not open."""

    def __init__(self, options: SerialOptions, chambers: tuple[int, ...], raw: bool) -> None:
        """`raw`: it is to take openings, else setpoints of pressure."""
        super().__init__(options, chambers, raw)
        self._line: Line | None = None
        self._cutter = frames.Cutter()
        self._clock = BoardClock()
        self._pending = Pending(options.timeout)
        self._number = self._answers = 0
        """Of the newest frame there, and of the newest answer, lost ones included."""
        self._wanted = -1
        """Flags of the newest command; -1: none was sent."""
        self._refused = self._refused_by_board = self._strangers = 0
        self._limited = False

    @property
    def name(self) -> str:
        """As "/dev/ttyACM0 at 1000000 baud"."""
        return f"{self.options.port} at {self.options.baud} baud"

    @property
    def rejected(self) -> int:  # type: ignore[override]  # counted by two
        """Frames that were none, of the board's here and of ours there, and answers to what was not asked."""
        return self._cutter.rejected + self._refused + self._strangers

    @property
    def late(self) -> int:  # type: ignore[override]  # counted where answers are matched
        """Answers that came after the timeout."""
        return self._pending.late

    @property
    def notice(self) -> str:  # type: ignore[override]
        """As "answers come after 15 ms, timeout is 10 ms"; "" where they come in time."""
        return self._pending.notice

    def open(self) -> None:
        """Open the port and greet the board; raises DeviceError or OSError, saying what does not fit."""
        self.close()
        self._line = Line(self.options.port, self.options.baud)
        self._greet(self.options.hello_timeout)

    def close(self) -> None:
        """Let go of the port; the board vents by itself."""
        line, self._line, self.board = self._line, None, None
        if line is not None:
            line.close()

    def exchange(self, outlet: Outlet, timeout: float) -> Reading | None:
        """Send a command and return the first new answer, to it or to an earlier one; None where none comes in time."""
        line, board = self._opened()
        before = self._answer(line, time.monotonic())
        self._send(outlet)
        patience = min(timeout, self.options.timeout, 0.5e-3 * board.watchdog_ms or timeout)
        reading = self._answer(line, time.monotonic() + patience)
        return before if reading is None else reading

    def _send(self, outlet: Outlet) -> None:
        """The next command, unless enough are on their way: what begins or ends a vent or a cut never waits."""
        line, board = self._opened()
        wanted, driven, targets = self._command(outlet, board.channels)
        asked_ns = time.monotonic_ns()
        if wanted == self._wanted and self._pending.full(asked_ns):
            return
        self._number += 1
        self._wanted = wanted
        sequence, host_us = self._number % 65536, asked_ns // 1000 % WRAP
        self._pending.sent(sequence, host_us, asked_ns)
        line.write(frames.command(sequence, host_us, wanted, driven, targets))

    def _opened(self) -> tuple[Line, HelloReply]:
        if self._line is None or self.board is None:
            raise DeviceError("the board is not open")
        return self._line, self.board

    def _command(self, outlet: Outlet, channels: int) -> tuple[int, int, list[int]]:
        """What is wanted, which channels are driven, and their targets. A number that is not finite vents all."""
        values = (outlet.openings if self.raw else outlet.pressures).tolist()
        targets, driven = [0] * channels, 0
        wanted = (frames.RAW if self.raw else 0) | (frames.CUT if outlet.cut else 0)
        if outlet.vent or not all(map(math.isfinite, values)):
            return wanted | frames.VENT, 0, targets
        scale, end = (frames.OPENING_END, frames.OPENING_END) if self.raw else (1, frames.SETPOINT_END)
        for channel, value in zip(self.chambers, values, strict=True):
            targets[channel] = round(min(max(value * scale, -end), end))
            driven |= 1 << channel
        return wanted, driven, targets

    def _answer(self, line: Line, deadline: float) -> Reading | None:
        """What the first new answers say, the newest of those that come together; None by `deadline`."""
        while data := line.read(deadline):
            if (newest := self._newest(data)) is not None:
                return self._reading(*newest)
        self._pending.line_was_empty(int(deadline * 1e9))
        return None

    def _newest(self, data: bytes) -> tuple[State, Match] | None:
        """The last frame that ends in `data` and answers a command; each one that does is counted."""
        newest, answered_ns = None, time.monotonic_ns()
        for frame in self._cutter.feed(data):
            if not isinstance(frame, State):
                continue
            match = self._pending.answered(frame, answered_ns)
            if match is None:
                self._strangers += 1
                continue
            self._answers += 1 + match.lost
            newest = frame, match
        return newest

    def _reading(self, state: State, match: Match) -> Reading:
        answered_ns = time.monotonic_ns()
        _, board = self._opened()
        if len(state.pressures) != board.channels:
            raise DeviceError(f"the board had {board.channels} channels and has {len(state.pressures)}")
        if state.boot != board.boot:
            log.warning("%s: the board started again", self.name)
            self._greet(self.options.timeout * 5)
        self._count(state)
        self._clock.answered(match.asked_ns, state.received_us, answered_ns)
        self.clock_offset = self._clock.offset_ns * 1e-9
        read_ns = min(self._clock.ours(state.read_us, state.received_us), answered_ns)
        pressures = [state.pressures[channel] for channel in self.chambers]
        values = np.array([math.nan if pressure == frames.BROKEN else pressure for pressure in pressures], float)
        return Reading(read_ns, values, reasons(state.stopped, board), self._answers)

    def _count(self, state: State) -> None:
        """Add what the board refused since last, and say once that it holds setpoints down."""
        self._refused += (state.rejected - self._refused_by_board) % 65536
        self._refused_by_board = state.rejected
        limited = bool(state.outputs & frames.LIMITED)
        if limited and not self._limited and self.board:
            log.warning("%s: the board holds what is above its %d Pa", self.name, self.board.pressure_max)
        self._limited = limited

    def _greet(self, patience: float) -> None:
        """Ask until the board says what it is; DeviceError after `patience` [s], or where it does not fit."""
        line, end = self._line, time.monotonic() + patience
        asked: set[tuple[int, int]] = set()
        if line is None:
            raise DeviceError("the board is not open")
        line.forget()
        while time.monotonic() < end:
            self._number += 1
            host_us = time.monotonic_ns() // 1000 % WRAP
            asked.add((self._number % 65536, host_us))
            line.write(frames.hello(self._number % 65536, host_us))
            found = self._hello(line, asked, min(end, time.monotonic() + ASK_AGAIN))
            if found is not None:
                return self._accept(found)
        raise DeviceError(
            f"nothing answers at {self.name}: is this firmware's board there, and not in its boot loader?"
        )

    def _hello(self, line: Line, asked: set[tuple[int, int]], deadline: float) -> HelloReply | None:
        """The answer to one of the hellos `asked`, each its sequence and our clock; None by `deadline`."""
        while data := line.read(deadline):
            try:
                found = [frame for frame in self._cutter.feed(data) if isinstance(frame, HelloReply)]
            except frames.VersionError as error:
                raise DeviceError(f"{error}: install the firmware that came with this version of Tendril") from error
            for frame in found:
                if (frame.sequence, frame.host_us) in asked:
                    return frame
        return None

    def _accept(self, board: HelloReply) -> None:
        if max(self.chambers) >= board.channels:
            raise DeviceError(
                f"valves.chambers names channel {max(self.chambers)}; the board has 0 to {board.channels - 1}"
            )
        needed, what = (
            (frames.TAKES_OPENINGS, "openings") if self.raw else (frames.HOLDS_PRESSURE, "setpoints of pressure")
        )
        if not board.capabilities & needed:
            raise DeviceError(f"the board {board.name} takes no {what}")
        self.board = board
        self._clock = BoardClock()
        self._pending.forget()
        self._wanted = -1
        self._refused_by_board = 0


class BoardClock:
    """The board's microseconds, which wrap after 72 minutes, on our clock."""

    def __init__(self) -> None:
        self._clock = TwoWayClock()
        self._device_us = 0
        self._best: tuple[int, int, int] | None = None
        self._given_ns = 0
        self.offset_ns = 0
        """Ours minus the board's, unwrapped [ns]."""

    def answered(self, asked_ns: int, received_us: int, answered_ns: int) -> None:
        """The board had a frame of `asked_ns` at its `received_us`, and its answer was here at `answered_ns`."""
        self._device_us += apart(received_us, self._device_us % WRAP)
        way = answered_ns - asked_ns
        if self._best is None or way < self._best[2] - self._best[0]:
            self._best = (asked_ns, self._device_us * 1000, answered_ns)
        if answered_ns - self._given_ns > CLOCK_EVERY_NS:
            self._clock.answered(*self._best)
            self._best, self._given_ns, self.offset_ns = None, answered_ns, self._clock.offset_ns

    def ours(self, then_us: int, received_us: int) -> int:
        """The board's `then_us`, near its `received_us` of the newest answer, on our clock [ns]."""
        return (self._device_us + apart(then_us, received_us)) * 1000 + self.offset_ns


def apart(later_us: int, earlier_us: int) -> int:
    """Between two times of a clock of 32 bits [us], the shorter way round."""
    return (later_us - earlier_us + WRAP // 2) % WRAP - WRAP // 2


def reasons(stopped: int, board: HelloReply) -> str:
    """Why the board drives nothing, in words; "" where it obeys."""
    words = {
        frames.BOOT: "it started again",
        frames.GREETED: "it has not been vented since it was connected",
        frames.WATCHDOG: f"its watchdog vented: no command for {board.watchdog_ms} ms",
        frames.OVER_PRESSURE: f"a pressure was above its {board.pressure_trip} Pa",
        frames.E_STOP_INPUT: "its hardware stop was pressed",
        frames.BROKEN_SENSOR: "a pressure sensor in use is broken",
    }
    told = stopped & ~frames.GREETED or stopped  # that it waits for a vent goes without saying where there is more
    return "; ".join(text for bit, text in words.items() if told & bit)
