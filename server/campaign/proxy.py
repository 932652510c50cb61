"""A TCP proxy between server and rig that cuts, stalls, delays, or stalls at random as loss does on TCP.

Where network namespaces have no netem this is what a bad network does to a TCP stream: bytes come late, never wrong.
"""

import contextlib
import queue
import random
import socket
import time
from dataclasses import dataclass
from functools import partial

from controller.system.thread import SupervisedThread, in_thread
from server.campaign.waiting import wait

CHUNK = 1 << 16
RETRANSMIT = 0.2
"""First wait for a lost packet [s], doubled with every further loss (Linux' least TCP_RTO_MIN)."""


@dataclass
class Weather:
    """What the link suffers now."""

    cut: bool = False
    stalled: bool = False
    delay: float = 0.0
    """In each direction [s]."""
    loss: float = 0.0

    def lateness(self) -> float:
        """How much later the next chunk arrives [s]."""
        late, wait_s = self.delay, RETRANSMIT
        while random.random() < self.loss:
            late, wait_s = late + wait_s, 2 * wait_s
        return late


class Proxy:
    """Listens on a free port of this machine and joins every connection with one to `port`."""

    def __init__(self, port: int) -> None:
        self.weather = Weather()
        self._to = port
        self._open: list[socket.socket] = []
        self._listening = socket.create_server(("127.0.0.1", 0))
        self._thread = SupervisedThread("proxy", self._accept)
        self._thread.start()

    @property
    def endpoint(self) -> str:
        """Where the server connects."""
        return f"tcp/127.0.0.1:{self._listening.getsockname()[1]}"

    def cut(self) -> None:
        """Close every connection, and refuse new ones until `mend`."""
        self.weather.cut = True
        while self._open:
            _close(self._open.pop())

    def mend(self) -> None:
        """Let everything through at once, what waits too."""
        self.weather = Weather()

    def close(self) -> None:
        """End for good."""
        self._thread.stop(0.0)
        self.cut()
        _close(self._listening)

    def _accept(self) -> None:
        while not self._thread.stopping:
            try:
                near, _ = self._listening.accept()
                far = None if self.weather.cut else socket.create_connection(("127.0.0.1", self._to))
            except OSError:
                continue
            if far is None:
                _close(near)
                continue
            self._open += [near, far]
            for source, sink in ((near, far), (far, near)):
                source.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                waiting: queue.Queue[tuple[float, bytes]] = queue.Queue()
                in_thread("proxy", partial(self._read, source, waiting))
                in_thread("proxy", partial(self._write, waiting, sink))

    def _read(self, source: socket.socket, waiting: "queue.Queue[tuple[float, bytes]]") -> None:
        due, data = 0.0, b"begin"
        while data:
            try:
                data = source.recv(CHUNK)
            except OSError:
                data = b""
            now = time.monotonic()
            due = max(due, now + self.weather.lateness()) if self.weather != Weather() else now
            waiting.put((due, data))

    def _write(self, waiting: "queue.Queue[tuple[float, bytes]]", sink: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while (item := waiting.get())[1]:
                wait(lambda item=item: self._arrived(item[0]), 600.0, "a packet", 1e-3)  # type: ignore[misc]
                sink.sendall(item[1])
        _close(sink)

    def _arrived(self, due: float) -> bool:
        weather = self.weather
        calm = weather == Weather()
        return calm or (not weather.stalled and time.monotonic() >= due) or weather.cut


def _close(end: socket.socket) -> None:
    with contextlib.suppress(OSError):
        end.shutdown(socket.SHUT_RDWR)
    end.close()
