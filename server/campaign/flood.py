"""Floods: what clients may send too much of, as fast as a process of its own can.

`python -m server.campaign.flood URL SECONDS [NAME [RECORDING]]`, with the operator's address as `tendril up` prints it:
the mixed one, which is everything at once, or one that a viewer can make.
"""

import base64
import contextlib
import json
import os
import select
import socket
import struct
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import cycle
from typing import NamedTuple
from urllib.parse import urlsplit

import httpx
import msgpack  # type: ignore[import-untyped]
import viser
from websockets.sync.client import connect

from controller.system.thread import in_thread
from server.app.app import openapi_schema
from server.campaign.rows.abuse import MESSAGES, REQUESTS
from server.campaign.viewer import Asked, asked
from server.scene.drag import CAMERA

MIXED = "mixed"
SOCKETS, PRESENCE, VISER, SESSIONS, CONNECTIONS = WITHOUT_ROUTE = (
    "live sockets",
    "presence sockets",
    "viser messages",
    "sessions",
    "connections",
)
SEVERAL = 6
"""Connections of a flood of one kind."""
FRAMES = 100
"""Messages of one write on a socket."""
PIPELINED = 20
"""Requests of one write."""
PAUSE_S = 0.02
"""After a connection that the server ended."""
_TALK = ('{"type": "ping", "t": 1.5}', '{"type": "target", "id": 1, "x": 0.1, "y": 0.1, "start": true}')
_VISER = f"viser-v{viser.__version__}"
_POSE = {
    "type": CAMERA,
    "wxyz": [1.0, 0.0, 0.0, 0.0],
    "position": [0.0, 0.0, 1.0],
    "fov": 0.5,
    "near": 0.01,
    "far": 10.0,
    "image_height": 100,
    "image_width": 100,
    "look_at": [0.0, 0.0, 0.0],
    "up_direction": [0.0, 1.0, 0.0],
}


class Pour(NamedTuple):
    """One connection at a time: what is said first, whose answer is awaited, and then again and again until it ends."""

    hello: Callable[[], bytes]
    what: Iterator[bytes]
    once: bool = False
    """Each connection is left after the first of `what`."""


def viewer_floods(recording: str) -> list[str]:
    """Names of all that a viewer can make, of a server with this recording."""
    return [*(one.name for one in asked(openapi_schema(), recording)), *WITHOUT_ROUTE]


class Flood:
    """What one process sends to the server at `url`; each connection in a thread of its own."""

    def __init__(self, url: str, recording: str = "none") -> None:
        """Sign in at the address with the token."""
        self._origin, self._token = url.split("/?token=")
        self._to = (urlsplit(self._origin).hostname or "", urlsplit(self._origin).port or 80)
        with httpx.Client(base_url=self._origin, trust_env=False, timeout=30.0) as client:
            client.post("/api/session", json={"token": self._token})
            self._cookie = "; ".join(f"{name}={value}" for name, value in client.cookies.items())
        self._asked, self._drain = asked(openapi_schema(), recording), Drain()

    def run(self, name: str, seconds: float) -> None:
        """Until the time is over: MIXED, or one of `viewer_floods`. Raises StopIteration for another name."""
        self._end = time.monotonic() + seconds
        pours = self._mixed() if name == MIXED else [self._kind(name) for _ in range(SEVERAL)]
        with ThreadPoolExecutor(len(pours)) as threads:
            for done in [threads.submit(self._pour, pour) for pour in pours]:
                done.result()

    def _mixed(self) -> list[Pour]:
        requests = [Asked(method, path, body) for method, path, body in REQUESTS]
        return [
            self._kind(SOCKETS),
            Pour(partial(self._upgrade, "/ws/live"), cycle([_frames(MESSAGES)])),
            self._kind(VISER),
            Pour(bytes, cycle([self._requests([one]) for one in self._asked])),
            Pour(bytes, cycle([self._requests(requests)])),
            Pour(bytes, cycle([self._requests([Asked("GET", "/api/session")], known=False)])),
            Pour(bytes, cycle([self._requests([Asked("POST", "/api/session", {"token": "guess"})], known=False)])),
            Pour(bytes, cycle([b"GET / HTTP/1.1\r\nhost: "])),
            self._kind(CONNECTIONS),
        ]

    def _kind(self, name: str) -> Pour:
        if name == SOCKETS:
            return Pour(partial(self._upgrade, "/ws/live"), cycle([_frames(_TALK)]))
        if name == PRESENCE:
            return Pour(self._presence, cycle([_frames(('{"type": "presence", "n": 1}',))]))
        if name == VISER:
            poses = _frames((bytes(msgpack.packb(_POSE)),))
            return Pour(partial(self._upgrade, "/viser", f"sec-websocket-protocol: {_VISER}\r\n"), cycle([poses]))
        if name == SESSIONS:
            sign_in = Asked("POST", "/api/session", {"token": self._token})
            return Pour(bytes, cycle([self._requests([sign_in], known=False)]))
        if name == CONNECTIONS:
            return Pour(bytes, cycle([b"GET / HTTP/1.1\r\nhost: "]), once=True)
        return Pour(bytes, cycle([self._requests([next(one for one in self._asked if one.name == name)])]))

    def _pour(self, pour: Pour) -> None:
        while time.monotonic() < self._end:
            with contextlib.suppress(OSError):
                self._talk(socket.create_connection(self._to, 2.0), pour)
            time.sleep(0.0 if pour.once else PAUSE_S)

    def _talk(self, link: socket.socket, pour: Pour) -> None:
        try:
            link.sendall(greeting := pour.hello())
            if greeting:
                link.recv(4096)
            self._drain.add(link)
            link.sendall(next(pour.what))
            while not pour.once and time.monotonic() < self._end:
                link.sendall(next(pour.what))
        finally:
            if not pour.once:  # else it stays open for as long as the server lets it
                self._drain.close(link)

    def _upgrade(self, path: str, more: str = "") -> bytes:
        key = base64.b64encode(os.urandom(16)).decode()
        upgrade = f"connection: upgrade\r\nupgrade: websocket\r\nsec-websocket-version: 13\r\nsec-websocket-key: {key}"
        return self._head("GET", path, f"{upgrade}\r\norigin: {self._origin}\r\n{more}")

    def _presence(self) -> bytes:
        url = f"{self._origin.replace('http', 'ws')}/ws/live"
        live = connect(url, additional_headers={"cookie": self._cookie}, proxy=None, max_size=None)
        page = json.loads(live.recv())["page"]
        in_thread("live", partial(deque, live, 0))  # it stays open for as long as it is read
        return self._upgrade(f"/ws/presence/{page}")

    def _requests(self, which: Sequence[Asked], known: bool = True) -> bytes:
        made = []
        for method, path, body in which:
            kind = "text/csv" if isinstance(body, str) else "application/json"
            data = b"" if body is None else (body if isinstance(body, str) else json.dumps(body)).encode()
            more = f"content-type: {kind}\r\ncontent-length: {len(data)}\r\n" if body is not None else ""
            made.append(self._head(method, path, more, known) + data)
        return b"".join(made) * (PIPELINED // len(made) + 1)

    def _head(self, method: str, path: str, more: str, known: bool = True) -> bytes:
        cookie = f"cookie: {self._cookie}\r\n" if known else ""
        return f"{method} {path} HTTP/1.1\r\nhost: {self._to[0]}:{self._to[1]}\r\n{cookie}{more}\r\n".encode()


class Drain:
    """Reads away what comes on any number of connections, until the server ends them.

    In one thread: a thousand that wake at once would keep the machine from all others for a tenth of a second.
    """

    def __init__(self) -> None:
        self._links: dict[int, socket.socket] = {}
        self._poll, self._lock = select.epoll(), threading.Lock()
        in_thread("drain", self._read)

    def add(self, link: socket.socket) -> None:
        """Read on it from now on."""
        with self._lock:
            self._links[link.fileno()] = link
            self._poll.register(link, select.EPOLLIN)

    def close(self, link: socket.socket) -> None:
        """Close it."""
        with self._lock:
            self._links.pop(link.fileno(), None)
            link.close()

    def _read(self) -> None:
        while True:
            for number, _ in self._poll.poll():
                with self._lock:
                    if number in self._links and _ended(number):
                        self._links.pop(number).close()


def _ended(number: int) -> bool:
    """Whether nothing more comes of this file; what has come is read."""
    try:
        return not os.read(number, 1 << 16)
    except BlockingIOError:
        return False
    except OSError:
        return True


def _frames(messages: Sequence[str | bytes]) -> bytes:
    """`FRAMES` masked WebSocket frames with these messages, one after the other."""
    frames = []
    for message, _ in zip(cycle(messages), range(FRAMES), strict=False):
        data = message.encode() if isinstance(message, str) else message
        size = bytes([0x80 | len(data)]) if len(data) < 126 else bytes([0x80 | 126]) + struct.pack(">H", len(data))
        frames.append(bytes([0x81 if isinstance(message, str) else 0x82]) + size + b"\0\0\0\0" + data)
    return b"".join(frames)


if __name__ == "__main__":
    os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))  # its machine is another: here it gets what is left
    Flood(sys.argv[1], *sys.argv[4:]).run((sys.argv[3:] or [MIXED])[0], float(sys.argv[2]))
