"""Who the server is, and what its bodies and markers are called."""

import struct
from collections import Counter
from dataclasses import dataclass, field

from controller.drivers.capture.natnet.packets import Cursor, Malformed, Version

MARKER_SET, RIGID_BODY, SKELETON, FORCE_PLATE, DEVICE, CAMERA, ASSET = range(7)
_INFO = struct.Struct("<256s4B4BQH?4B")
_OLD = struct.Struct("<256s4B4B")
_TYPED_MODELS = 0x3
"""Marker sets and rigid bodies. Motive 3.1 was seen to answer no request without a mask, nor one with more bits."""

MODEL_REQUESTS = (struct.pack("<I", _TYPED_MODELS), b"")
"""Payloads of a request for the model definitions, tried in turn."""


@dataclass(frozen=True)
class ServerInfo:
    """Answer to NAT_CONNECT."""

    application: str
    version: Version
    """Of NatNet."""
    frequency: int
    """Of the clock of its stamps [ticks/s]."""
    data_port: int
    multicast: str
    """Group that it sends to; "" where it sends to each client."""


@dataclass
class Names:
    """Names by which points are told, from the model definitions."""

    bodies: dict[int, str] = field(default_factory=dict)
    """By streaming id."""
    members: dict[tuple[int, int], str] = field(default_factory=dict)
    """Of markers, by id of their asset and their own number in it, from 1."""
    sets: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Names of the markers of each marker set, in the order in which frames give their positions."""

    def own_sets(self) -> dict[str, tuple[str, ...]]:
        """Sets that someone made: Motive adds one for each body, and one of all markers, which tell nothing new.

        A marker is called by its name alone where only one such set has that name, else "set.marker".
        """
        mine = {name: markers for name, markers in self.sets.items() if name not in ("all", *self.bodies.values())}
        times = Counter(marker for markers in mine.values() for marker in markers)
        return {name: tuple(m if times[m] == 1 else f"{name}.{m}" for m in markers) for name, markers in mine.items()}


def parse_server_info(payload: bytes) -> ServerInfo:
    """Raises Malformed; a server older than 3.0 says nothing of its clock, which is 0 then."""
    if len(payload) < _OLD.size:
        raise Malformed(f"{len(payload)} bytes say nothing of a server")
    name = payload[:256].partition(b"\0")[0].decode("utf-8", "replace")
    if len(payload) < _INFO.size:
        return ServerInfo(name, (payload[260], payload[261]), 0, 0, "")
    _, _, _, _, _, major, minor, _, _, frequency, port, multicast, *group = _INFO.unpack_from(payload)
    if not 0 < frequency <= 10**12:
        raise Malformed(f"a clock of {frequency} ticks a second")
    return ServerInfo(name, (major, minor), frequency, port, ".".join(map(str, group)) if multicast else "")


def parse_definitions(payload: bytes, version: Version) -> Names:
    """Model definitions as far as they are understood; raises Malformed where nothing is.

    What follows a definition of an unknown kind cannot be found before 4.1, and is left out.
    """
    cursor, names = Cursor(payload, version), Names()
    for _ in range(cursor.count(4)):
        kind = cursor.u32()
        if version >= (4, 1):
            size = cursor.u32()
            begin = cursor.skip(size)
            _definition(kind, Cursor(payload[begin : begin + size], version), names)
        elif kind <= RIGID_BODY:
            _definition(kind, cursor, names)
        else:
            break  # Motive sends sets and bodies first
    return names


def _definition(kind: int, cursor: Cursor, names: Names) -> None:
    if kind == MARKER_SET:
        name = cursor.text()
        names.sets[name] = tuple(cursor.text() for _ in range(cursor.count(1)))
    elif kind == RIGID_BODY:
        _body(cursor, names)
    elif kind == ASSET:
        _asset(cursor, names)


def _body(cursor: Cursor, names: Names) -> None:
    name, number = cursor.text(), cursor.u32()
    cursor.skip(4 + 12)  # parent, offset
    count = cursor.count(16)
    cursor.skip(16 * count)  # positions, active labels
    markers = [cursor.text() for _ in range(count)] if cursor.version >= (4, 0) else [""] * count
    names.bodies[number] = name
    for index, marker in enumerate(markers, start=1):
        names.members[number, index] = f"{name}.{marker or index}"


def _asset(cursor: Cursor, names: Names) -> None:
    """A trained marker set (4.1)."""
    name = cursor.text()
    cursor.skip(4)  # kind
    number = cursor.u32()
    bones = Names()
    for _ in range(cursor.count(25)):
        _body(cursor, bones)
    for _ in range(cursor.count(23)):
        marker, index = cursor.text(), cursor.u32()
        cursor.skip(12 + 4 + 2)  # position, size, flags
        names.members[number, index] = f"{name}.{marker}"
