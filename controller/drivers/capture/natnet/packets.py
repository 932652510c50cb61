"""Frames of mocap data as NatNet 3.0, 3.1, 4.0 and 4.1 send them, read without trust.

No element is ever looked at before its bytes are known to be there, so a datagram (65 kB) bounds memory and time. The
layout is what several public clients agree on. From 4.1 on each section says its size in bytes after its count.
"""

import struct
from collections.abc import Callable
from typing import NamedTuple, TypeVar

import numpy as np

from controller.arrays import Array32, Rows
from controller.drivers.device import COORDINATE_MAX_M, plausible
from controller.errors import TendrilError

T = TypeVar("T")
Version = tuple[int, int]

VERSIONS: tuple[Version, ...] = ((3, 0), (3, 1), (4, 0), (4, 1))
"""Whose frames we read, oldest first."""
SETS_MAX = 512

CONNECT, SERVER_INFO, REQUEST, RESPONSE = 0, 1, 2, 3
REQUEST_MODEL_DEF, MODEL_DEF, FRAME, MESSAGE_STRING = 4, 5, 7, 8
DISCONNECT, KEEP_ALIVE, DISCONNECT_BY_TIMEOUT, ECHO_REQUEST, ECHO_RESPONSE = 9, 10, 11, 12, 13
UNRECOGNIZED_REQUEST = 100

OCCLUDED, POINT_CLOUD, MODEL_FILLED, UNLABELLED = 0x01, 0x02, 0x04, 0x10
"""Bits of a labelled marker's `flags`."""
TRACKED = 0x01
"""Bit of a body's `flags`."""
MODELS_CHANGED = 0x02
"""Bit of a frame's `flags`."""

MARKER = np.dtype([("id", "<u4"), ("at", "<f4", (3,)), ("size", "<f4"), ("flags", "<u2"), ("residual", "<f4")])
"""A labelled marker; `residual` is there since 3.0."""
BODY = np.dtype([("id", "<i4"), ("at", "<f4", (3,)), ("turn", "<f4", (4,)), ("error", "<f4"), ("flags", "<u2")])
POSITION = np.dtype(("<f4", (3,)))
HEADER = struct.Struct("<HH")
_U16, _U32 = struct.Struct("<H"), struct.Struct("<I")
_TIMES = struct.Struct("<IIdQQQ")


class Malformed(TendrilError):
    """Bytes that are no message of this kind and version; the text says where."""


class Frame(NamedTuple):
    """One frame of mocap data."""

    number: int
    sets: list[tuple[str, Array32]]
    """Name and positions (K,3) [m] of each marker set; 0, 0, 0 is a marker that is not seen."""
    others: Array32
    """(M,3) markers without a model [m]; Motive repeats some of them among `labelled`."""
    bodies: Rows
    """(B,) of `BODY`."""
    labelled: Rows
    """(L,) of `MARKER`."""
    timestamp: float
    """Since the server's software started [s]."""
    exposed: int
    """Middle of the exposure [ticks of the server's clock]; 0: not known."""
    flags: int


class Cursor:
    """Reads on in `data`, and raises Malformed before it would read beyond its end."""

    def __init__(self, data: bytes, version: Version) -> None:
        self.data, self.at, self.version = data, 0, version

    @property
    def left(self) -> int:
        """Bytes that were not read yet."""
        return len(self.data) - self.at

    def skip(self, size: int) -> int:
        """Step over `size` bytes; where they began."""
        if not 0 <= size <= self.left:
            raise Malformed(f"{size} bytes at {self.at} of {len(self.data)}")
        begin = self.at
        self.at += size
        return begin

    def fields(self, form: struct.Struct) -> tuple[int | float, ...]:
        """The numbers of `form`."""
        return form.unpack_from(self.data, self.skip(form.size))

    def u16(self) -> int:
        """An unsigned number of 2 bytes."""
        return int(_U16.unpack_from(self.data, self.skip(2))[0])

    def u32(self) -> int:
        """An unsigned number of 4 bytes."""
        return int(_U32.unpack_from(self.data, self.skip(4))[0])

    def count(self, least: int) -> int:
        """How many elements of at least `least` bytes follow."""
        found = self.u32()
        if found * least > self.left:
            raise Malformed(f"{found} elements at {self.at} of {len(self.data)}")
        return found

    def text(self, longest: int = 1024) -> str:
        """A text that ends with a zero byte."""
        end = self.data.find(0, self.at, self.at + longest + 1)
        if end < 0:
            raise Malformed(f"text without end at {self.at}")
        begin, self.at = self.at, end + 1
        return self.data[begin:end].decode("utf-8", "replace")

    def records(self, kind: np.dtype[np.void], count: int) -> Rows:
        """`count` records as they lie in the datagram."""
        begin = self.skip(kind.itemsize * count)
        return np.frombuffer(self.data, kind, count, begin)

    def section(self, least: int, read: Callable[["Cursor", int], T]) -> T:
        """What `read` makes of a section and its count of elements, which take at least `least` bytes each."""
        count = self.u32()
        end = self.u32() + self.at if self.version >= (4, 1) else None
        if count * least > self.left or (end is not None and end > len(self.data)):
            raise Malformed(f"section of {count} elements at {self.at} of {len(self.data)}")
        found = read(self, count)
        if end is not None:
            if self.at > end:
                raise Malformed(f"section ends at {end}, its elements at {self.at}")
            self.at = end  # what a newer version may have added to it
        return found


def message(datagram: bytes) -> tuple[int, bytes]:
    """Kind and payload of a message; raises Malformed."""
    if len(datagram) < HEADER.size:
        raise Malformed(f"{len(datagram)} bytes are no message")
    kind, size = HEADER.unpack_from(datagram)
    if size > len(datagram) - HEADER.size:
        raise Malformed(f"{size} bytes announced, {len(datagram) - HEADER.size} came")
    return kind, datagram[HEADER.size : HEADER.size + size]


def parse_frame(payload: bytes, version: Version) -> Frame:
    """A frame of mocap data of NatNet `version`; raises Malformed."""
    cursor = Cursor(payload, version)
    number = cursor.u32()
    sets = cursor.section(5, _sets)
    others = cursor.section(POSITION.itemsize, _positions)
    bodies = cursor.section(BODY.itemsize, lambda c, n: c.records(BODY, n))
    cursor.section(8, _skeletons)
    if version >= (4, 1):
        cursor.section(12, _assets)
    labelled = cursor.section(MARKER.itemsize, lambda c, n: c.records(MARKER, n))
    cursor.section(8, _analog)  # force plates
    cursor.section(8, _analog)  # devices
    _, _, timestamp, exposed, _, _ = cursor.fields(_TIMES)
    if cursor.left >= 10:
        cursor.skip(8)  # time of a grandmaster clock, from 4.1 on
    flags = cursor.u16()
    for places in (others, bodies["at"], labelled["at"], *(at for _, at in sets)):
        if not plausible(places):
            raise Malformed(f"a coordinate is beyond {COORDINATE_MAX_M:g} m")
    return Frame(number, sets, others, bodies, labelled, float(timestamp), int(exposed), flags)


def _positions(cursor: Cursor, count: int) -> Array32:
    begin = cursor.skip(POSITION.itemsize * count)
    return np.frombuffer(cursor.data, "<f4", 3 * count, begin).reshape(count, 3)


def _sets(cursor: Cursor, count: int) -> list[tuple[str, Array32]]:
    if count > SETS_MAX:
        raise Malformed(f"{count} marker sets, more than {SETS_MAX}")
    return [(cursor.text(), _positions(cursor, cursor.count(POSITION.itemsize))) for _ in range(count)]


def _skeletons(cursor: Cursor, count: int) -> None:
    for _ in range(count):
        cursor.skip(4)
        cursor.skip(BODY.itemsize * cursor.u32())


def _assets(cursor: Cursor, count: int) -> None:
    """Trained marker sets: their markers are among the labelled ones, too."""
    for _ in range(count):
        cursor.skip(4)
        cursor.skip(BODY.itemsize * cursor.u32())
        cursor.skip(MARKER.itemsize * cursor.u32())


def _analog(cursor: Cursor, count: int) -> None:
    for _ in range(count):
        cursor.skip(4)
        for _ in range(cursor.count(4)):
            cursor.skip(4 * cursor.u32())
