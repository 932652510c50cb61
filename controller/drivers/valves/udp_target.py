"""A Simulink or LabVIEW target over UDP as a device: one datagram there, one back (docs/udp.md)."""

import random
import socket
import time
from typing import Annotated

import numpy as np
from pydantic import Field as Bounds

from controller.drivers.clocks import TwoWayClock
from controller.drivers.device import DeviceError, Outlet, Reading, ValveDevice
from controller.drivers.valves.udp_layout import (
    COMMAND,
    CUT,
    LIMIT,
    RAW,
    VENT,
    WATCHDOG,
    Command,
    Reply,
    pack_command,
    unpack_reply,
)
from controller.errors import ParameterError
from controller.schema.layout import Model

KEPT = 64
"""Commands whose answer may still come."""
ROUND_NS = 50_000_000
"""Of the answers in so long, the quickest tells of the target's clock [ns]."""
STOPPED = {WATCHDOG: "the target's watchdog vented", LIMIT: "the target vented: a pressure was above its own limit"}


class UdpOptions(Model):
    """Where the target is."""

    host: Annotated[str, Bounds(min_length=1, max_length=253)] = "192.168.1.2"
    port: Annotated[int, Bounds(ge=1, le=65535)] = 25000
    local_port: Annotated[int, Bounds(ge=0, le=65535)] = 0
    """From which we send, where the target answers to a fixed one only; 0: any."""
    connect_time: Annotated[float, Bounds(ge=0.05, le=10.0)] = 1.0
    """Longest wait for its first answer [s]."""
    setpoint_min: Annotated[float, Bounds(ge=-100e3, le=0.0)] = -90e3
    """No setpoint below this leaves [Pa]."""
    setpoint_max: Annotated[float, Bounds(gt=0.0, le=1e6)] = 700e3
    """No setpoint above this leaves [Pa]."""


class UdpTarget(ValveDevice[UdpOptions]):
    """Channels 0 to 3. What the target vents by itself it must keep vented until it is told to vent."""

    Options = UdpOptions
    capabilities = ("setpoints", "raw openings", "watchdog of its own", "supply cut by the target")
    clock = "two-way"
    period = 0.002

    def __init__(self, options: UdpOptions, chambers: tuple[int, ...], raw: bool) -> None:
        """Raises ParameterError for a channel above 3."""
        super().__init__(options, chambers, raw)
        if max(chambers) > 3:
            raise ParameterError(f"valves.chambers = {list(chambers)}: a target has channels 0 to 3")
        self._order = np.array(chambers)
        self._socket: socket.socket | None = None
        self._clock = TwoWayClock()
        self._offset = self._round_ends = 0
        self._quickest: Reply | None = None
        self._quickest_at = 0
        self._sent: dict[int, int] = {}
        """Sequence and time of late commands [ns]."""
        self._session = self._sequence = 0
        self._seen = -1
        """Newest sequence that was answered."""
        self._cut = False
        """As the newest command had it."""
        self._newest = 0
        """Time of the newest reading [ns]."""

    @property
    def name(self) -> str:
        """As "target at 192.168.1.2:25000"."""
        return f"target at {self.options.host}:{self.options.port}"

    def open(self) -> None:
        """Begin a session with a vented command; DeviceError if the target does not answer.

        One that was lost while the supply was cut is not connected to it again: the loop says when.
        """
        self.close()
        here = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket = here
        try:
            here.bind(("", self.options.local_port))
            here.connect((self.options.host, self.options.port))  # nothing from elsewhere reaches us
        except OSError as error:
            self.close()
            raise DeviceError(f"no way to {self.options.host}:{self.options.port}: {error.strerror}") from error
        self._clock, self._session = TwoWayClock(), random.getrandbits(32)
        self._sequence, self._seen, self._round_ends = 0, -1, 0
        self._quickest = None
        self._sent.clear()
        try:
            self._begin()
        except BaseException:
            self.close()
            raise

    def _begin(self) -> None:
        if self.exchange(Outlet.vented(self._cut), self.options.connect_time) is None:
            raise DeviceError(f"no answer from {self.options.host}:{self.options.port}")

    def close(self) -> None:
        """Never raises; a thread that waits for an answer is woken."""
        gone, self._socket = self._socket, None
        if gone is None:
            return
        try:
            gone.shutdown(socket.SHUT_RDWR)
        except OSError:  # never connected
            pass
        gone.close()

    def exchange(self, outlet: Outlet, timeout: float) -> Reading | None:
        """Send a command, and wait for its answer, or that of an earlier one."""
        until = time.monotonic() + timeout
        here = self._open_socket()
        here.send(pack_command(self._command(outlet)))
        late: Reading | None = None
        while True:
            here.settimeout(max(until - time.monotonic(), 1e-4))
            try:
                data = here.recv(COMMAND.size + 1)
            except TimeoutError:
                return late
            if self._socket is None:
                raise DeviceError("closed")
            arrived = time.monotonic_ns()
            reply = unpack_reply(data)
            if reply is None or not self._expected(reply):
                self.rejected += 1
            else:
                late = self._reading(reply, arrived)
                if reply.sequence == self._sequence:
                    return late
            if time.monotonic() >= until:
                return late

    def _open_socket(self) -> socket.socket:
        if self._socket is None:
            raise DeviceError("not open")
        return self._socket

    def _command(self, outlet: Outlet) -> Command:
        """The next command; what is not finite vents."""
        wanted, vent, self._cut = outlet.wanted(self.raw), outlet.vents(self.raw), outlet.cut
        pressures, openings = np.zeros(4), np.zeros(4)
        if not vent and self.raw:
            openings[self._order] = np.clip(wanted, -1.0, 1.0)
        elif not vent:
            pressures[self._order] = np.clip(wanted, self.options.setpoint_min, self.options.setpoint_max)
        flags = (VENT if vent else 0) | (CUT if outlet.cut else 0) | (RAW if self.raw else 0)
        self._sequence = (self._sequence + 1) & 0xFFFFFFFF
        now = self._sent[self._sequence] = time.monotonic_ns()
        if len(self._sent) > KEPT:
            del self._sent[next(iter(self._sent))]
        return Command(flags, self._sequence, self._session, now, tuple(pressures), tuple(openings))

    def _expected(self, reply: Reply) -> bool:
        """An answer to a late command of ours, and the first to it."""
        asked = reply.session == self._session and self._sent.get(reply.sequence) == reply.time
        return asked and (self._seen < 0 or 0 < (reply.sequence - self._seen) & 0xFFFFFFFF < 1 << 31)

    def _reading(self, reply: Reply, arrived: int) -> Reading:
        self._seen = reply.sequence
        self._tell_clock(reply, arrived)
        self._newest = max(self._newest, min(reply.read + self._offset, arrived))
        stopped = next((text for flag, text in STOPPED.items() if reply.flags & flag), "")
        return Reading(self._newest, np.array(reply.pressures)[self._order], stopped, reply.number)

    def _tell_clock(self, reply: Reply, arrived: int) -> None:
        if self._quickest is None or arrived - reply.time < self._quickest_at - self._quickest.time:
            self._quickest, self._quickest_at = reply, arrived
        if arrived < self._round_ends:
            return
        self._clock.answered(self._quickest.time, self._quickest.replied, self._quickest_at)
        self._offset, self._round_ends, self._quickest = self._clock.offset_ns, arrived + ROUND_NS, None
        self.clock_offset = self._offset * 1e-9
