"""Sockets to a NatNet server: one for questions and answers, one for frames. Only what the server sends is taken."""

import selectors
import socket
import struct
import time
from collections.abc import Callable
from contextlib import suppress
from typing import TypeVar

from controller.drivers.capture.natnet.definitions import ServerInfo, parse_server_info
from controller.drivers.capture.natnet.packets import CONNECT, HEADER, SERVER_INFO, Malformed, Version, message
from controller.drivers.device import DeviceError

T = TypeVar("T")

LARGEST = 65535
ANSWER = 0.25
"""After this an unanswered question is put again [s]."""
ATTEMPTS_MAX = 4
NAP = 0.05
"""Nothing wakes who waits when another thread closes the sockets: it looks so often [s]."""


class Link:
    """Open until `close`; `rejected` counts datagrams of others and those that are no message."""

    def __init__(self, server: str, port: int, local: str) -> None:
        """Open the socket for questions, at the address `local` or any; raises DeviceError or OSError."""
        try:
            self.server = socket.gethostbyname(server)
        except OSError as error:
            raise DeviceError(f"server = {server}: no such host ({error})") from error
        self._to = (self.server, port)
        self._local = local
        self.rejected = 0
        self._selector = selectors.DefaultSelector()
        self._sockets: list[socket.socket] = []
        self._commands = self._socket((local, 0), shared=False)

    def _socket(self, at: tuple[str, int], shared: bool) -> socket.socket:
        made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            if shared:
                made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            made.setblocking(False)
            made.bind(at)
        except OSError:
            made.close()
            raise
        self._sockets.append(made)
        self._selector.register(made, selectors.EVENT_READ)
        return made

    def listen(self, port: int, group: str) -> None:
        """Take frames at `port`, of the multicast `group` or, "", of those sent to us; raises OSError.

        Motive sends unicast frames to the port that asked; others send them to the data port of the machine.
        """
        if not group:
            with suppress(OSError):  # taken by someone else: Motive needs it not
                self._socket((self._local, port), shared=True)
            return
        data = self._socket((group, port), shared=True)
        member = socket.inet_aton(group) + socket.inet_aton(self._local or "0.0.0.0")
        data.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)

    def send(self, kind: int, payload: bytes = b"") -> None:
        """Send a message; raises OSError."""
        with suppress(BlockingIOError):
            self._commands.sendto(HEADER.pack(kind, len(payload)) + payload, self._to)

    def receive(self, timeout: float) -> tuple[int, bytes, int] | None:
        """Kind, payload and arrival [ns] of the next message; None for nonsense, or none in `timeout` [s] or NAP."""
        try:
            ready = self._selector.select(max(0.0, min(timeout, NAP)))
        except ValueError as error:
            raise DeviceError("the link was closed") from error
        for key, _ in ready:
            assert isinstance(key.fileobj, socket.socket)
            try:
                datagram, sender = key.fileobj.recvfrom(LARGEST)
            except BlockingIOError:
                continue
            arrived = time.monotonic_ns()
            try:
                if sender[0] != self.server:
                    raise Malformed(f"sent by {sender[0]}")
                return *message(datagram), arrived
            except Malformed:
                self.rejected += 1
                return None
        return None

    def ask(self, kind: int, payloads: tuple[bytes, ...], read: Callable[[int, bytes], T | None]) -> T | None:
        """Put a question, again and again, until `read` makes something of an answer; None where it never does."""
        for attempt in range(ATTEMPTS_MAX):
            self.send(kind, payloads[attempt % len(payloads)])
            deadline = time.monotonic() + ANSWER
            while (left := deadline - time.monotonic()) > 0:
                if (got := self.receive(left)) is not None:
                    try:
                        found = read(got[0], got[1])
                    except Malformed:
                        self.rejected += 1
                        continue
                    if found is not None:
                        return found
        return None

    def connect(self, version: Version) -> ServerInfo:
        """Become a client, and ask for frames of `version`; raises DeviceError where no one answers."""
        info = self.ask(CONNECT, (connect_request(version),), _server_info)
        if info is None:
            raise DeviceError(
                f"no NatNet server answers at {self._to[0]}:{self._to[1]}: is Motive streaming, on that interface?"
            )
        return info

    def close(self) -> None:
        """Close every socket."""
        for each in self._sockets:
            each.close()
        self._selector.close()


def connect_request(version: Version) -> bytes:
    """Who we are and, as servers from 4.0 on read it, whether all data are wanted and of which version."""
    ours = bytes((*version, 0, 0))
    return struct.pack("<256s4s4s?4sx", b"Tendril", ours, ours, False, ours)


def _server_info(kind: int, payload: bytes) -> ServerInfo | None:
    return parse_server_info(payload) if kind == SERVER_INFO else None
