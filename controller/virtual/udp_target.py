"""A Simulink or LabVIEW target on UDP that is not there: the datagrams of docs/udp.md, and a watchdog of its own."""

import threading
import time

import numpy as np

from controller.drivers.valves.udp_layout import (
    CUT,
    LIMIT,
    RAW,
    VENT,
    WATCHDOG,
    Command,
    Reply,
    pack_reply,
    unpack_command,
)
from controller.schema.hardware import CHANNELS
from controller.virtual.peers import Drive, ReadPressures, TakeDrive
from controller.virtual.udp_end import Sender, UdpEnd

WATCHDOG_S = 0.1
"""Without a command for so long it vents [s]."""
OFFSET_NS = 3_600_000_000_000
"""Its clock is an hour ahead of ours [ns]."""
PRESSURE_MAX = 800e3
"""Its own limit [Pa]."""


class UdpTargetPeer:
    """A ValvePeer. It answers every sender of a right command; a new session ends the one before."""

    def __init__(self, read_pressures: ReadPressures, take_drive: TakeDrive, port: int = 0) -> None:
        """On a free port if `port` is 0; it keeps it when it is plugged in again."""
        self._read, self._take = read_pressures, take_drive
        self._port = port
        self._end = UdpEnd("udp-target", self._hear, lambda: self._look(time.monotonic()), WATCHDOG_S / 20)
        self._number = 0
        self._half = False
        self.silent = False
        """As `freeze` has it."""
        self.rejected = 0
        """Datagrams that were no command, or an old one."""
        self._begin()

    def _begin(self) -> None:
        self._session = self._sequence = -1
        self._heard = 0.0
        self._stopped = WATCHDOG
        """Flags for which it vents; they stay until it is told to vent."""
        self._cut = False
        """The newest command cut the supply, which then stays so without a host."""

    @property
    def options(self) -> dict[str, str | int]:
        """For the driver "udp"."""
        return {"host": "127.0.0.1", "port": self._port}

    def plug(self) -> None:
        """Listen; raises OSError where the port is taken."""
        if not self._end.is_open:
            self._port = self._end.plug("127.0.0.1", self._port)

    def unplug(self) -> None:
        """Hear and say nothing any more; its watchdog vents when it is due."""
        self._end.unplug()
        timer = threading.Timer(WATCHDOG_S, lambda: self._look(time.monotonic()))
        timer.daemon = True
        timer.start()

    def close(self) -> None:
        """As `unplug`: nothing is left."""
        self.unplug()

    def freeze(self) -> None:
        """Give no answers, and hear nothing."""
        self.silent = True

    def thaw(self) -> None:
        """Answer again."""
        self.silent = False

    def reset(self) -> None:
        """Begin again, as after a loss of power: vented, its count and session forgotten."""
        self._number = 0
        self._begin()
        self._take(_vented(True))

    def half_frame(self) -> None:
        """Send only the first half of the next answer."""
        self._half = True

    def take(self, data: bytes) -> Reply | None:
        """Act on a datagram as the target does; None where it is rejected."""
        command = unpack_command(data)
        if command is None or not self._new(command):
            self.rejected += 1
            return None
        self._session, self._sequence, self._heard = command.session, command.sequence, time.monotonic()
        self._obey(command)
        now = time.monotonic_ns() + OFFSET_NS
        pressures = tuple(float(value) for value in self._read()[:4])
        self._number += 1
        return Reply(self._stopped, command.sequence, command.session, command.time, now, now, pressures, self._number)

    def _new(self, command: Command) -> bool:
        if command.session != self._session:
            return bool(command.flags & VENT)  # a session begins vented
        return 0 < (command.sequence - self._sequence) & 0xFFFFFFFF < 1 << 31

    def _obey(self, command: Command) -> None:
        self._cut = bool(command.flags & CUT)
        if np.nanmax(self._read()[:4]) > PRESSURE_MAX:
            self._stopped |= LIMIT
        elif command.flags & VENT:
            self._stopped = 0
        if self._stopped or command.flags & VENT:
            self._take(_vented(self._cut))
            return
        pressures, openings = np.zeros(CHANNELS), np.zeros(CHANNELS)
        pressures[:4], openings[:4] = command.pressures, command.openings
        self._take(Drive(pressures, openings, bool(command.flags & RAW), False, self._cut))

    def _hear(self, data: bytes, sender: Sender) -> None:
        if not self.silent:
            self._answer(data, sender)
        self._look(time.monotonic())

    def _answer(self, data: bytes, sender: Sender) -> None:
        reply = self.take(data)
        if reply is None:
            return
        answer = pack_reply(reply)
        if self._half:
            self._half, answer = False, answer[: len(answer) // 2]
        self._end.send(answer, sender)

    def _look(self, now: float) -> None:
        if self._heard and now - self._heard >= WATCHDOG_S and not self._stopped & WATCHDOG:
            self._stopped |= WATCHDOG
            self._take(_vented(self._cut))


def _vented(cut: bool) -> Drive:
    return Drive(np.zeros(CHANNELS), np.full(CHANNELS, -1.0), False, True, cut)
