"""A mixed flood: everything at once that clients may send too much of, as fast as a process of its own can.

`python -m server.campaign.flood URL SECONDS`, with the operator's address as `tendril up` prints it.
"""

import base64
import contextlib
import json
import os
import socket
import struct
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import cycle
from urllib.parse import urlsplit

import httpx

from controller.system.thread import in_thread
from server.campaign.rows.abuse import MESSAGES, REQUESTS

FRAMES = 100
"""Messages of one write on a socket."""
PIPELINED = 20
"""Requests of one write."""
PAUSE = 0.02
"""After a connection that the server ended [s]."""
_TALK = ('{"type": "ping", "t": 1.5}', '{"type": "target", "id": 1, "x": 0.1, "y": 0.1, "start": true}')
_DRAWING = {"strokes": [[[0.2, 0.01 * i] for i in range(5)]], "timing": {"kind": "duration", "duration": 5}}


class Flood:
    """What one process sends to the server at `url`; each kind in a thread of its own."""

    def __init__(self, url: str, seconds: float) -> None:
        self._origin, token = url.split("/?token=")
        self._to = (urlsplit(self._origin).hostname or "", urlsplit(self._origin).port or 80)
        with httpx.Client(base_url=self._origin, trust_env=False, timeout=30.0) as client:
            client.post("/api/session", json={"token": token})
            self._cookie = "; ".join(f"{name}={value}" for name, value in client.cookies.items())
        self._end = time.monotonic() + seconds

    def run(self) -> None:
        """Until the time is over."""
        kinds: list[tuple[Callable[[], bytes], Iterator[bytes]]] = [
            (self._upgrade, cycle([_frames(_TALK)])),
            (self._upgrade, cycle([_frames(MESSAGES)])),
            (bytes, cycle([self._requests([("GET", "/api/health", None)])])),
            (bytes, cycle([self._requests(REQUESTS)])),
            (bytes, cycle([self._requests([("POST", "/api/drawings/plan", _DRAWING), ("GET", "/api/runs", None)])])),
            (bytes, cycle([self._requests([("GET", "/api/session", None)], known=False)])),
            (bytes, cycle([self._requests([("POST", "/api/session", {"token": "guess"})], known=False)])),
            (bytes, cycle([b"GET / HTTP/1.1\r\nhost: "])),
        ]
        with ThreadPoolExecutor(len(kinds)) as threads:
            for done in [threads.submit(self._pour, *kind) for kind in kinds]:
                done.result()

    def _pour(self, hello: Callable[[], bytes], what: Iterator[bytes]) -> None:
        while time.monotonic() < self._end:
            with contextlib.suppress(OSError), socket.create_connection(self._to, 2.0) as link:
                link.settimeout(2.0)
                link.sendall(greeting := hello())
                if greeting:
                    link.recv(4096)
                in_thread("drain", partial(_drain, link))
                while time.monotonic() < self._end:
                    link.sendall(next(what))
            time.sleep(PAUSE)

    def _upgrade(self) -> bytes:
        key = base64.b64encode(os.urandom(16)).decode()
        more = f"connection: upgrade\r\nupgrade: websocket\r\nsec-websocket-version: 13\r\nsec-websocket-key: {key}\r\n"
        return self._head("GET", "/ws/live", more)

    def _requests(self, which: "Iterator | list | tuple", known: bool = True) -> bytes:  # type: ignore[type-arg]
        made = []
        for method, path, body in which:
            text = b"" if body is None else json.dumps(body).encode()
            more = f"content-type: application/json\r\ncontent-length: {len(text)}\r\n" if body is not None else ""
            made.append(self._head(method, path, more, known) + text)
        return b"".join(made) * (PIPELINED // len(made) + 1)

    def _head(self, method: str, path: str, more: str, known: bool = True) -> bytes:
        cookie = f"cookie: {self._cookie}\r\n" if known else ""
        return f"{method} {path} HTTP/1.1\r\nhost: {self._to[0]}:{self._to[1]}\r\n{cookie}{more}\r\n".encode()


def _drain(link: socket.socket) -> None:
    with contextlib.suppress(OSError):
        while link.recv(1 << 16):
            pass


def _frames(messages: "tuple[str | bytes, ...] | tuple[str, ...]") -> bytes:
    """`FRAMES` masked WebSocket frames with these messages, one after the other."""
    frames = []
    for message, _ in zip(cycle(messages), range(FRAMES), strict=False):
        data = message.encode() if isinstance(message, str) else message
        size = bytes([0x80 | len(data)]) if len(data) < 126 else bytes([0x80 | 126]) + struct.pack(">H", len(data))
        frames.append(bytes([0x81 if isinstance(message, str) else 0x82]) + size + b"\0\0\0\0" + data)
    return b"".join(frames)


if __name__ == "__main__":
    Flood(sys.argv[1], float(sys.argv[2])).run()
