"""A person at the page, as the server meets one: signed in, on the live socket, with presence or without."""

import contextlib
import json
import math
import socket
import time
from functools import partial
from typing import Any
from urllib.parse import urlsplit

import httpx
import numpy as np
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from controller.reference.library import CENTRE
from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.schema.modes import Mode
from controller.system.thread import SupervisedThread
from server.campaign.waiting import Failed, require, wait
from server.plots.messages import Kind

REPEAT_S = 0.05
"""Between two signs of presence, and between two targets of a drag [s]."""
START_TIMEOUT_S = 60.0
"""Longest wait for a server that starts [s]."""
ANSWER_MAX_S = 60.0
"""Longest wait for an answer; a machine that is slow is no defect, and its rows say what was late [s]."""
RADIUS, TURNS = 20e-3, 0.5
"""Of the circle on which a hand drags the target [m], [Hz]."""
ROW = record_dtype(Telemetry)


def http_client(origin: str) -> httpx.Client:
    """Each request has a connection of its own: one that was kept may be left from a dead server."""
    alone = httpx.Limits(max_keepalive_connections=0)
    return httpx.Client(
        base_url=origin, headers={"Origin": origin}, timeout=ANSWER_MAX_S, limits=alone, trust_env=False
    )


class Person:
    """One browser: a cookie, a live socket that is read, and presence at 20 Hz while `present`."""

    def __init__(self, url: str) -> None:
        """Sign in at the address with the token."""
        self.origin, token = url.split("/?token=")
        self._http = http_client(self.origin)
        self.present, self.dragging, self.asleep = False, False, False
        self.frame: np.void | None = None
        self.status: dict[str, Any] = {}
        self.log: list[str] = []
        self._known: set[str] = set()
        self._n = self._targets = 0
        self.ask("POST", "/api/session", token=token)
        self._socket = self._connect()
        self._thread = SupervisedThread("person", self._tell)
        self._thread.start()

    def request(self, method: str, path: str, **body: Any) -> httpx.Response:
        """The answer, success or not. Nothing is asked twice: a server that is late still does what it was asked."""
        try:
            return self._http.request(method, path, json=body or None)
        except httpx.TransportError as error:
            raise Failed(f"{method} {path}: {error or type(error).__name__}") from error

    def ask(self, method: str, path: str, **body: Any) -> Any:
        """The answer as JSON; `Failed` unless it is a success."""
        answer = self.request(method, path, **body)
        require(answer.is_success, f"{method} {path} was answered with {answer.status_code}: {answer.text[:200]}")
        return answer.json()

    def command(self, request: str, **more: Any) -> Any:
        """Ask the rig for another mode."""
        return self.ask("POST", "/api/command", request=request, **more)

    def operate(self) -> None:
        """Take the lease as soon as it is free, and be present."""
        wait(lambda: self.request("POST", "/api/lease").is_success, 10.0, "the lease")
        self.present = True

    def reconnect(self) -> None:
        """Open the live socket again as soon as the server answers and hears the rig, and operate."""
        wait(self._answered, START_TIMEOUT_S, "a server that hears the rig", 0.1)
        self.vanish()
        self._socket = self._connect()
        self.asleep = False
        self.operate()

    def post_bare(self, path: str, body: bytes) -> None:
        """Send a request on a connection of its own, and do not wait for the answer: for measuring when it acts."""
        where = urlsplit(self.origin)
        cookies = "; ".join(f"{name}={value}" for name, value in self._http.cookies.items())
        head = (
            f"POST {path} HTTP/1.1\r\nhost: {where.netloc}\r\ncookie: {cookies}\r\ncontent-type: application/json\r\n"
        )
        self._bare = socket.create_connection((where.hostname or "", where.port or 80))
        self._bare.sendall(f"{head}connection: close\r\ncontent-length: {len(body)}\r\n\r\n".encode() + body)

    def send(self, **message: Any) -> None:
        """Say something on the socket."""
        self._socket.send(json.dumps(message))

    def shout(self, text: str | bytes) -> None:
        """Send anything at all on the socket."""
        self._socket.send(text)

    def drag(self) -> None:
        """Press on the target and move it along a circle until `dragging` is taken back."""
        self._targets, self.dragging = 0, True

    def vanish(self) -> None:
        """The socket is gone without a good-bye."""
        with contextlib.suppress(OSError):
            self._socket.socket.shutdown(socket.SHUT_RDWR)

    def sees(self, text: str, mark: int, seconds: float = 10.0) -> str:
        """The line with `text` in the log that the page shows, after the first `mark` lines."""
        return wait(
            lambda: next((line for line in self.log[mark:] if text in line), ""), seconds, f"{text!r} in the page's log"
        )

    def shows(self, mode: Mode, t_ns: int) -> bool:
        """Whether the page shows `mode`, in a row of the rig after `t_ns`."""
        frame = self.frame
        return frame is not None and bool(frame["mode"] == mode and frame["t_ns"] > t_ns)

    def close(self) -> None:
        """Leave."""
        self._thread.stop(0.0)
        self.vanish()
        self._http.close()

    def _answered(self) -> bool:
        with contextlib.suppress(Failed):
            answer = self.request("GET", "/api/health")
            return answer.is_success and bool(answer.json()["rig_connected"])
        return False

    def _connect(self) -> ClientConnection:
        cookies = "; ".join(f"{name}={value}" for name, value in self._http.cookies.items())
        headers = {"Cookie": cookies, "Origin": self.origin}
        url = f"{self.origin.replace('http', 'ws')}/ws/live"
        found = connect(url, additional_headers=headers, proxy=None, max_size=None, ping_interval=None)
        SupervisedThread("ear", partial(self._hear, found)).start()
        return found

    def _hear(self, live: ClientConnection) -> None:
        with contextlib.suppress(ConnectionClosed):
            for message in live:
                while self.asleep:
                    time.sleep(REPEAT_S)
                if isinstance(message, str):
                    self._read(json.loads(message))
                elif message[0] == Kind.FRAME:
                    self.frame = np.frombuffer(message, ROW, offset=8)[0]

    def _read(self, message: dict[str, Any]) -> None:
        for event in message["log"] if message["type"] == "hello" else [message]:
            if event["type"] == "event" and (line := f"{event['time']} {event['text']}") not in self._known:
                self._known.add(line)
                self.log.append(event["text"])
        if message["type"] == "status":
            self.status = message
        if message["type"] == "refused":
            self.log.append(f"refused: {message['detail']}")

    def _tell(self) -> None:
        while not self._thread.wait(REPEAT_S):
            if not self.asleep:
                with contextlib.suppress(ConnectionClosed, OSError):
                    self._say()

    def _say(self) -> None:
        if self.present:
            self._n += 1
            self.send(type="presence", n=self._n)
        if self.dragging:
            self._targets += 1
            angle = 2 * math.pi * TURNS * REPEAT_S * self._targets
            x, y = CENTRE[0] + RADIUS * math.cos(angle), CENTRE[1] + RADIUS * math.sin(angle)
            self.send(type="target", id=self._targets, x=x, y=y, start=self._targets == 1)
