"""Motion capture, or sensors of shape, as JSON in UDP datagrams: for systems whose own programs can send such.

    {"t": 12.345, "n": 42, "points": [[0.1, 0.2, 0.0], null], "labels": ["tip", "middle"], "quality": [1, 0]}
    {"t": 12.345, "n": 42, "arcs": [0.05, 0.1], "angles": [0.2, null]}

A sender that answers {"ask": 7} with {"ask": 7, "t": 12.345}, to the port that asked, has its clock read both ways.
"""

import json
import math
import socket
import time
from collections.abc import Sequence
from contextlib import suppress
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field as Bounds

from controller.arrays import Array
from controller.drivers.clocks import OneWayClock, TwoWayClock
from controller.drivers.device import COORDINATE_MAX_M, POINTS_MAX, Angles, CaptureDevice, DeviceError, Sample
from controller.errors import TendrilError, spelled
from controller.schema.layout import Model

Host = Annotated[str, spelled(r"^[A-Za-z0-9.-]{1,253}$", "a host name or IPv4 address")]
LocalHost = Annotated[str, spelled(r"^[0-9.]{0,15}$", "an IPv4 address of this machine, or nothing for any")]

LARGEST = 65535
LABEL_MAX_LETTERS = 64
"""Letters of a label."""
QUICK = 4
"""Questions that are put to a new sender at once."""
BEAT = 0.5
"""Between questions for the sender's clock [s]."""
OLDEST = 10_000_000_000
"""No frame is older when it comes [ns]."""


class JsonOptions(Model):
    """Where datagrams come in, and from whom."""

    sender: Host
    """The only machine that is listened to."""
    port: Annotated[int, Bounds(ge=1, le=65535)]
    """At which they come in here."""
    local_address: LocalHost = ""
    """Address of the interface at which they come in; nothing: any."""
    ask: bool = True
    """Ask for the sender's clock; where it never answers, the quickest datagrams tell it."""


class _Refused(TendrilError):
    """A datagram that is no frame."""


class JsonCapture(CaptureDevice[JsonOptions]):
    """Points or angles from whatever sends JSON."""

    Options = JsonOptions
    capabilities = ("labelled markers", "unlabelled markers", "angles", "quality", "two-way clock")

    def __init__(self, options: JsonOptions) -> None:
        """Touches nothing."""
        super().__init__(options)
        self._socket: socket.socket | None = None
        self._sender = ""
        self._reset()

    def _reset(self) -> None:
        self.clock = "arrival"
        self._two_way, self._one_way = TwoWayClock(), OneWayClock()
        self._asked: dict[int, int] = {}
        self._question, self._quick = 0, QUICK
        self._next_beat = 0.0
        self._peer: tuple[str, int] | None = None

    @property
    def name(self) -> str:
        """As "JSON from 192.168.1.10 at port 5005"."""
        return f"JSON from {self.options.sender} at port {self.options.port}"

    def open(self) -> None:
        """Listen; raises DeviceError or OSError."""
        self.close()
        self._reset()
        try:
            self._sender = socket.gethostbyname(self.options.sender)
        except OSError as error:
            raise DeviceError(f"sender = {self.options.sender}: no such host ({error})") from error
        made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            made.bind((self.options.local_address, self.options.port))
        except OSError:
            made.close()
            raise
        self._socket = made

    def close(self) -> None:
        """Close the socket; who waits at it is woken."""
        made, self._socket = self._socket, None
        if made is not None:
            with suppress(OSError):  # never connected
                made.shutdown(socket.SHUT_RDWR)
            made.close()

    def read(self, timeout: float) -> Sample | Angles | None:
        """The next frame within `timeout` [s]."""
        made = self._socket
        if made is None:
            raise DeviceError(f"{self.name} is not open")
        deadline = time.monotonic() + timeout
        while True:
            self._beat(made)
            made.settimeout(max(1e-4, min(deadline - time.monotonic(), BEAT)))
            try:
                datagram, peer = made.recvfrom(LARGEST)
            except TimeoutError:
                datagram, peer = b"", ("", 0)
            if datagram and (frame := self.take(datagram, peer, time.monotonic_ns())) is not None:
                return frame
            if time.monotonic() >= deadline:
                return None

    def _beat(self, made: socket.socket) -> None:
        """Ask for the time, twice a second; at first more often."""
        now = time.monotonic()
        if not self.options.ask or self._peer is None or now < self._next_beat:
            return
        self._next_beat = now + (0.025 if self._quick else BEAT)
        self._question, self._quick = self._question + 1, max(0, self._quick - 1)
        self._asked[self._question] = time.monotonic_ns()
        self._asked.pop(self._question - 8, None)
        try:
            made.sendto(b'{"ask": %d}' % self._question, self._peer)
        except OSError:
            return  # it is not there any more, or not yet

    def take(self, datagram: bytes, peer: tuple[str, int], arrived: int) -> Sample | Angles | None:
        """What a datagram of `peer` says that came at `arrived` [ns]; None, and counted, where it is no frame."""
        try:
            if peer[0] != self._sender:
                raise _Refused(f"sent by {peer[0]}")
            told = _parsed(datagram)
            if "ask" in told:
                self._answered(told, arrived)
                return None
            if peer != self._peer:  # begun again, with another clock perhaps
                self._peer, self._two_way, self._quick = peer, TwoWayClock(), QUICK
            return self._frame(told, arrived)
        except _Refused:
            self.rejected += 1
            return None

    def _answered(self, told: dict[str, Any], arrived: int) -> None:
        number, device = told["ask"], _nanoseconds(told.get("t"))
        asked = self._asked.pop(number, None) if type(number) is int else None
        if asked is None:
            raise _Refused("an answer to no question")
        self._two_way.answered(asked, device, arrived)
        self.clock, self.clock_offset = "two-way", self._two_way.offset_ns * 1e-9

    def _frame(self, told: dict[str, Any], arrived: int) -> Sample | Angles:
        number = told.get("n", -1)
        if type(number) is not int or not -1 <= number < 2**62:
            raise _Refused("n is no count")
        if "points" in told:
            points = _points(told["points"])
            labels, quality = _labels(told.get("labels"), len(points)), _quality(told.get("quality"), len(points))
            return Sample(self._captured(told, arrived), points, labels, quality, number)
        arcs, angles = _numbers(told.get("arcs"), False), _numbers(told.get("angles"), True)
        if len(arcs) != len(angles) or not np.all(np.diff(arcs) > 0.0) or np.any(arcs < 0.0):
            raise _Refused("arcs do not rise, or are not as many as angles")
        return Angles(self._captured(told, arrived), arcs, angles, number)

    def _captured(self, told: dict[str, Any], arrived: int) -> int:
        """Time of capture on our clock [ns]."""
        if told.get("t") is None:
            return arrived
        device = _nanoseconds(told["t"])
        if self._two_way.known:
            captured = self._two_way.ours(device)
            if not arrived - OLDEST < captured < arrived + OLDEST:
                raise _Refused("a time of capture that cannot be")
            return min(captured, arrived)
        captured = self._one_way.heard(device, arrived)
        way: Literal["one-way"] = "one-way"
        self.clock, self.clock_offset = way, self._one_way.offset_ns(device) * 1e-9
        return captured


def _parsed(datagram: bytes) -> dict[str, Any]:
    try:
        told = json.loads(datagram, parse_constant=_no_constant)
    except (ValueError, RecursionError) as error:
        raise _Refused("no JSON") from error
    if not isinstance(told, dict):
        raise _Refused("no object")
    return told


def _no_constant(text: str) -> float:
    raise ValueError(f"{text} is no JSON")


def _number(value: object, bound: float) -> float:
    if type(value) not in (int, float) or not -bound <= value <= bound:  # type: ignore[operator]
        raise _Refused("no number within its bounds")
    return float(value)  # type: ignore[arg-type]


def _nanoseconds(seconds: object) -> int:
    return round(_number(seconds, 1e12) * 1e9)


def _rows(value: object) -> Sequence[object]:
    if not isinstance(value, list) or len(value) > POINTS_MAX:
        raise _Refused(f"no list of at most {POINTS_MAX}")
    return value


def _numbers(value: object, holes: bool) -> Array:
    """(K,), nan for null where there may be holes."""
    rows = _rows(value)
    return np.array([math.nan if holes and row is None else _number(row, COORDINATE_MAX_M) for row in rows], float)


def _points(value: object) -> Array:
    """(M,2) or (M,3), nan for null."""
    rows = _rows(value)
    width = next((len(row) for row in rows if isinstance(row, list)), 3)
    if width not in (2, 3):
        raise _Refused("points have 2 or 3 coordinates")
    found = [[math.nan] * width if row is None else _numbers(row, True).tolist() for row in rows]
    if any(len(row) != width for row in found):
        raise _Refused("points differ in their number of coordinates")
    return np.array(found, float).reshape(-1, width)


def _labels(value: object, count: int) -> tuple[str, ...]:
    if value is None:
        return ()
    labels = tuple("" if label is None else label for label in _rows(value))
    if len(labels) != count or not all(isinstance(label, str) and len(label) <= LABEL_MAX_LETTERS for label in labels):
        raise _Refused(f"labels are not {count} texts of at most {LABEL_MAX_LETTERS} letters")
    return labels  # type: ignore[return-value]


def _quality(value: object, count: int) -> Array | None:
    if value is None:
        return None
    found = np.nan_to_num(_numbers(value, True))
    if len(found) != count or np.any(found < 0.0) or np.any(found > 1.0):
        raise _Refused(f"quality is not {count} numbers of [0, 1]")
    return found
