"""A NatNet server that answers and streams as Motive does: 3.0, 3.1, 4.0, 4.1, unicast and multicast."""

import socket
import struct
import threading
import time

import numpy as np

from controller.arrays import Array
from controller.virtual.natnet_wire import Version, definitions, frame, message, server_info
from controller.virtual.udp_end import Sender, UdpEnd, free_udp_port

CLIENTS = 16
"""Most at a time."""
CLIENT_TIMEOUT_S = 10.0
"""A client that gives no sign of life for so long gets nothing more [s]."""
CONNECT, REQUEST, RESPONSE, MODEL_REQUEST, MODEL_DEF = 0, 2, 3, 4, 5
FRAME, DISCONNECT, KEEP_ALIVE, ECHO, ECHO_ANSWER, DISCOVERY, UNRECOGNIZED = 7, 9, 10, 12, 13, 14, 100
VERSIONS = ((3, 0), (3, 1), (4, 0), (4, 1))


class _Client:
    def __init__(self, version: Version) -> None:
        self.version, self.heard = version, time.monotonic()


class NatNetServer:
    """Each labelled point is a rigid body, and a marker of the marker set "tendril"; the rest are unlabelled.

    The server's clock has ticks of its own, and begins `offset` seconds away from this machine's.
    """

    def __init__(
        self,
        version: str = "4.1",
        labels: tuple[str, ...] = (),
        multicast: str = "",
        *,
        address: str = "127.0.0.1",
        command_port: int = 0,
        data_port: int = 0,
        frequency: int = 10_000_000,
        offset: float = 4321.0,
        drift: float = 0.0,
        echo: bool = True,
        to_data_port: bool = False,
    ) -> None:
        """`drift`: how much faster its clock runs than ours; ports of 0 are chosen when they are needed first.

        `to_data_port`: unicast frames go to the data port of a client's machine, not to the port that asked.
        """
        major, _, minor = version.partition(".")
        self.version: Version = (int(major), int(minor))
        self.multicast, self.address = multicast, address
        self.command_port, self.data_port = command_port, data_port
        self.frequency, self.offset, self.drift = frequency, offset, drift
        self.echo, self.to_data_port = echo, to_data_port
        self.number = 0
        """Of the last frame."""
        self._labels, self._changed = labels, False
        self._clients: dict[tuple[str, int], _Client] = {}
        self._lock = threading.Lock()
        self._end = UdpEnd("natnet server", self._take)
        self._born = time.monotonic_ns()

    @property
    def options(self) -> dict[str, str | int]:
        """Of the driver "natnet"; ports that were left open are chosen now."""
        self._choose_ports()
        return {
            "server": self.address,
            "local_address": self.address,
            "command_port": self.command_port,
            "data_port": self.data_port,
            "multicast_address": self.multicast,
        }

    @property
    def clients(self) -> list[tuple[str, int]]:
        """Who gets frames by unicast."""
        with self._lock:
            return list(self._clients)

    def ticks(self, t_ns: int) -> int:
        """A time of this machine's monotonic clock on the server's."""
        since = (t_ns - self._born) * (1.0 + self.drift)
        return int((since * 1e-9 + self.offset) * self.frequency)

    def plug(self) -> None:
        """Begin to answer and stream; raises OSError."""
        if self._end.is_open:
            return
        self._choose_ports()
        group = socket.inet_aton(self.address)
        several = (socket.IPPROTO_IP, socket.IP_MULTICAST_IF, group), (socket.IPPROTO_IP, socket.IP_MULTICAST_LOOP, 1)
        self._end.plug(self.address, self.command_port, several if self.multicast else ())

    def _choose_ports(self) -> None:
        self.command_port = self.command_port or free_udp_port(self.address)
        self.data_port = self.data_port or free_udp_port(self.address)

    def unplug(self) -> None:
        """Vanish: no one is told, and every client is forgotten."""
        self._end.unplug()
        with self._lock:
            self._clients.clear()

    def show(self, t_ns: int, points: Array, labels: tuple[str, ...]) -> None:
        """Send a frame that was captured at `t_ns` (monotonic): points (M,3) [m], "" unlabelled, nan not seen."""
        if not self._end.is_open:
            return
        named = tuple(label for label in labels if label)
        if named != self._labels:
            self._labels, self._changed = named, True
        self.number += 1
        times = (self.ticks(t_ns), self.ticks(time.monotonic_ns()))
        packets: dict[Version, bytes] = {}
        rows = np.asarray(points, float).reshape(-1, 3)
        for target, version in self._targets():
            if version not in packets:
                payload = frame(version, self.number, rows, labels, times, self.frequency, self._changed)
                packets[version] = message(FRAME, payload)
            self._end.send(packets[version], target)

    def _targets(self) -> list[tuple[tuple[str, int], Version]]:
        if self.multicast:
            return [((self.multicast, self.data_port), self.version)]
        now = time.monotonic()
        with self._lock:
            self._clients = {at: who for at, who in self._clients.items() if now - who.heard < CLIENT_TIMEOUT_S}
            every = list(self._clients.items())
        return [((at[0], self.data_port) if self.to_data_port else at, who.version) for at, who in every]

    def _take(self, datagram: bytes, sender: Sender) -> None:
        arrived = time.monotonic_ns()
        if len(datagram) >= 4:
            answer = self._answer(int.from_bytes(datagram[:2], "little"), datagram[4:], sender, arrived)
            if answer is not None:
                self._end.send(answer, sender)

    def _answer(self, kind: int, payload: bytes, sender: tuple[str, int], arrived: int) -> bytes | None:
        if kind in (CONNECT, DISCOVERY):
            if kind == CONNECT:
                self._join(sender, payload)
            return message(1, server_info(self.version, self.frequency, self.data_port, self.multicast))
        if kind == ECHO and len(payload) >= 8:
            return message(ECHO_ANSWER, payload[:8] + struct.pack("<Q", self.ticks(arrived))) if self.echo else None
        if kind == MODEL_REQUEST:
            self._changed = False
            return message(MODEL_DEF, definitions(self._version_of(sender), self._labels))
        if kind == REQUEST:
            return self._command(payload.partition(b"\0")[0].decode("ascii", "replace"), sender)
        with self._lock:
            if kind == KEEP_ALIVE and sender in self._clients:
                self._clients[sender].heard = time.monotonic()
            elif kind == DISCONNECT:
                self._clients.pop(sender, None)
        return None if kind in (KEEP_ALIVE, DISCONNECT) else message(UNRECOGNIZED, b"")

    def _join(self, sender: tuple[str, int], payload: bytes) -> None:
        version = self.version
        if len(payload) >= 269:  # connection options: subscribed data only, version of the frames
            version = self._allowed((payload[265], payload[266])) or version
        with self._lock:
            if sender in self._clients or len(self._clients) < CLIENTS:
                self._clients[sender] = _Client(version)

    def _allowed(self, asked: Version) -> Version | None:
        """`asked` where we may send it: from 4.0 on, by unicast, up to our own."""
        free = not self.multicast and self.version >= (4, 0)
        return asked if free and asked in VERSIONS and asked <= self.version else None

    def _version_of(self, sender: tuple[str, int]) -> Version:
        with self._lock:
            return self._clients[sender].version if sender in self._clients else self.version

    def _command(self, text: str, sender: tuple[str, int]) -> bytes:
        word, _, value = text.partition(",")
        if word == "Bitstream":
            major, _, minor = value.partition(".")
            asked = self._allowed((int(major), int(minor))) if major.isdecimal() and minor.isdecimal() else None
            with self._lock:
                if asked is not None and sender in self._clients:
                    self._clients[sender].version = asked
            now = self._version_of(sender)
            return message(RESPONSE, f"Bitstream,{now[0]}.{now[1]}".encode() + b"\0")
        if word == "FrameRate":
            return message(RESPONSE, struct.pack("<f", 100.0))
        return message(UNRECOGNIZED, b"")
