"""A camera whose program sends JSON, as docs/motion-capture.md has it, and tells its clock when asked."""

import json
import math
import time
from contextlib import suppress

from controller.arrays import Array
from controller.virtual.udp_end import Sender, UdpEnd, free_udp_port

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
        self.port = port or free_udp_port(ADDRESS)
        self.offset, self.answers, self.dimensions = offset, answers, dimensions
        self.number = 0
        self._born = time.monotonic_ns()
        self._end = UdpEnd("json source", self._take)

    @property
    def options(self) -> dict[str, str | int]:
        """Of the driver "json"."""
        return {"sender": ADDRESS, "local_address": ADDRESS, "port": self.port}

    def seconds(self, t_ns: int) -> float:
        """A time of this machine's monotonic clock on the sender's [s]."""
        return (t_ns - self._born) * 1e-9 + self.offset

    def plug(self) -> None:
        """Begin to send; raises OSError."""
        if not self._end.is_open:
            self._end.plug(ADDRESS, 0)

    def unplug(self) -> None:
        """Vanish."""
        self._end.unplug()

    def show(self, t_ns: int, points: Array, labels: tuple[str, ...]) -> None:
        """Send a frame that was captured at `t_ns` (monotonic): points (M,3) [m], nan not seen."""
        rows = [[x if math.isfinite(x) else None for x in row[: self.dimensions]] for row in points.tolist()]
        self._send(t_ns, {"points": rows, "labels": list(labels)})

    def bend(self, t_ns: int, arcs: Array, angles: Array) -> None:
        """Send angles (K,) [rad] at arc lengths (K,) [m] instead."""
        self._send(t_ns, {"arcs": arcs.tolist(), "angles": [x if math.isfinite(x) else None for x in angles.tolist()]})

    def _send(self, t_ns: int, content: dict[str, object]) -> None:
        if self._end.is_open:
            self.number += 1
            frame = {"t": self.seconds(t_ns), "n": self.number} | content
            self._end.send(json.dumps(frame).encode(), (ADDRESS, self.port))

    def _take(self, datagram: bytes, sender: Sender) -> None:
        now = self.seconds(time.monotonic_ns())
        if self.answers:
            with suppress(ValueError, TypeError, KeyError):
                answer = {"ask": json.loads(datagram)["ask"], "t": now}
                self._end.send(json.dumps(answer).encode(), sender)
