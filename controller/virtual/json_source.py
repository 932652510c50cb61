"""A camera whose program sends JSON, as docs/motion-capture.md has it, and tells its clock when asked."""

import json
import math
import socket
import threading
import time
from contextlib import suppress

from controller.arrays import Array

ADDRESS = "127.0.0.1"


class JsonSource:
    """Sends to one port; its clock begins `offset` seconds away from this machine's."""

    def __init__(
        self,
        port: int = 0,
        *,
        offset: float = -100.0,
        answers: bool = True,
        dimensions: int = 3,
    ) -> None:
        """`port`: at which the driver listens; 0: one that is free now."""
        self.port = port or _free_port()
        self.offset, self.answers, self.dimensions = offset, answers, dimensions
        self.number = 0
        self._born = time.monotonic_ns()
        self._socket: socket.socket | None = None
        self._thread: threading.Thread | None = None

    @property
    def options(self) -> dict[str, str | int]:
        """Of the driver "json"."""
        return {"sender": ADDRESS, "local_address": ADDRESS, "port": self.port}

    def seconds(self, t_ns: int) -> float:
        """A time of this machine's monotonic clock on the sender's [s]."""
        return (t_ns - self._born) * 1e-9 + self.offset

    def plug(self) -> None:
        """Begin to send; raises OSError."""
        if self._socket is not None:
            return
        made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            made.bind((ADDRESS, 0))
        except OSError:
            made.close()
            raise
        made.settimeout(0.05)
        self._socket = made
        self._thread = threading.Thread(target=self._serve, args=(made,), name="json source", daemon=True)
        self._thread.start()

    def unplug(self) -> None:
        """Vanish."""
        made, self._socket = self._socket, None
        if made is not None and self._thread is not None:
            self._thread.join()
            made.close()

    def show(self, t_ns: int, points: Array, labels: tuple[str, ...]) -> None:
        """Send a frame that was captured at `t_ns` (monotonic): points (M,3) [m], nan not seen."""
        rows = [[x if math.isfinite(x) else None for x in row[: self.dimensions]] for row in points.tolist()]
        self._send(t_ns, {"points": rows, "labels": list(labels)})

    def bend(self, t_ns: int, arcs: Array, angles: Array) -> None:
        """Send angles (K,) [rad] at arc lengths (K,) [m] instead."""
        self._send(t_ns, {"arcs": arcs.tolist(), "angles": [x if math.isfinite(x) else None for x in angles.tolist()]})

    def _send(self, t_ns: int, content: dict[str, object]) -> None:
        made = self._socket
        if made is not None:
            self.number += 1
            frame = {"t": self.seconds(t_ns), "n": self.number} | content
            with suppress(OSError):
                made.sendto(json.dumps(frame).encode(), (ADDRESS, self.port))

    def _serve(self, made: socket.socket) -> None:
        while self._socket is made:
            try:
                datagram, peer = made.recvfrom(65535)
            except TimeoutError:
                continue
            except OSError:
                return
            now = self.seconds(time.monotonic_ns())
            if self.answers:
                with suppress(ValueError, TypeError, KeyError, OSError):
                    answer = {"ask": json.loads(datagram)["ask"], "t": now}
                    made.sendto(json.dumps(answer).encode(), peer)


def _free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asked:
        asked.bind((ADDRESS, 0))
        return int(asked.getsockname()[1])
