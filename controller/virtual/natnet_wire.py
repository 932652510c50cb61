"""The bytes that Motive sends, written by hand from the layout: it shares nothing with the parser that reads them."""

import math
import struct

from controller.arrays import Array

Version = tuple[int, int]

SET = "tendril"
"""Name of the marker set."""
SIZE = 0.012
"""Diameter of every marker [m]."""
_OCCLUDED, _SOLVED, _HAS_MODEL, _UNLABELLED = 0x01, 0x02, 0x08, 0x10
_POINT_CLOUD = 50000
"""Ids of markers without a model begin here."""
_SHORTEST_WAY = 0.0005
"""From the arrival of the cameras' data to the frame that leaves [s]."""


def message(kind: int, payload: bytes) -> bytes:
    """Header and payload."""
    return struct.pack("<HH", kind, len(payload)) + payload


def server_info(version: Version, frequency: int, data_port: int, multicast: str) -> bytes:
    """Answer to NAT_CONNECT."""
    motive = {(3, 0): (2, 0), (3, 1): (2, 1), (4, 0): (3, 0), (4, 1): (3, 1)}[version]
    group = bytes(map(int, multicast.split("."))) if multicast else bytes(4)
    return struct.pack(
        "<256s4B4BQH?4s", b"Motive", *motive, 0, 0, *version, 0, 0, frequency, data_port, bool(multicast), group
    )


def definitions(version: Version, labels: tuple[str, ...]) -> bytes:
    """Marker sets (ours, one for each body, "all") and rigid bodies, as Motive orders them."""
    sets = [_named_set(SET, labels), *(_named_set(label, ()) for label in labels), _named_set("all", labels)]
    bodies = [_body_definition(number, label) for number, label in enumerate(labels, start=1)]
    whole = struct.pack("<i", len(sets) + len(bodies))
    for kind, content in [*((0, each) for each in sets), *((1, each) for each in bodies)]:
        size = struct.pack("<i", len(content)) if version >= (4, 1) else b""
        whole += struct.pack("<i", kind) + size + content
    return whole


def _text(text: str) -> bytes:
    return text.encode()[:255] + b"\0"


def _named_set(name: str, markers: tuple[str, ...]) -> bytes:
    return _text(name) + struct.pack("<i", len(markers)) + b"".join(map(_text, markers))


def _body_definition(number: int, name: str) -> bytes:
    """Without markers of its own: name, id, parent, offset, number of markers."""
    return _text(name) + struct.pack("<ii3fi", number, -1, 0.0, 0.0, 0.0, 0)


def frame(
    version: Version,
    number: int,
    points: Array,
    labels: tuple[str, ...],
    ticks: tuple[int, int],
    frequency: int,
    changed: bool,
) -> bytes:
    """A frame of `points` (M,3) [m]; `ticks` of the exposure and of now."""
    names = [*labels, *[""] * (len(points) - len(labels))]
    named = [point for point, label in zip(points, names, strict=True) if label]
    others = [p for p, label in zip(points, names, strict=True) if not label and _seen(p)]
    places = b"".join(_place(point) for point in named)
    count = len(named)
    sets = [(SET, places, count), *((label, b"", 0) for label in names if label), ("all", places, count)]
    sections: list[tuple[int, bytes]] = [
        (len(sets), b"".join(_text(name) + struct.pack("<i", n) + content for name, content, n in sets)),
        (len(others), b"".join(_place(point) for point in others)),
        (count, b"".join(_body(k, point) for k, point in enumerate(named, start=1))),
        (0, b""),  # skeletons
    ]
    if version >= (4, 1):
        sections.append((0, b""))  # assets
    markers = [_marker(k, point, _SOLVED | _HAS_MODEL) for k, point in enumerate(named, start=1)]
    markers += [_marker(_POINT_CLOUD + k, point, _SOLVED | _UNLABELLED) for k, point in enumerate(others)]
    sections += [(len(markers), b"".join(markers)), (0, b""), (0, b"")]  # force plates, devices
    whole = struct.pack("<i", number)
    for elements, content in sections:
        size = struct.pack("<i", len(content)) if version >= (4, 1) else b""
        whole += struct.pack("<i", elements) + size + content
    return whole + _suffix(version, ticks, frequency, changed)


def _suffix(version: Version, ticks: tuple[int, int], frequency: int, changed: bool) -> bytes:
    """Time code, time since start, stamps of exposure, arrival and departure, flags, end of data."""
    exposed, now = ticks
    received = max(exposed, now - int(_SHORTEST_WAY * frequency))
    times = struct.pack("<IIdQQQ", 0, 0, exposed / frequency, exposed, received, now)
    grandmaster = bytes(8) if version >= (4, 1) else b""
    return times + grandmaster + struct.pack("<Hi", 0x02 if changed else 0, 0)


def _seen(point: Array) -> bool:
    return all(math.isfinite(x) for x in point)


def _place(point: Array) -> bytes:
    """A marker that is not seen is at the origin."""
    return struct.pack("<3f", *(point if _seen(point) else (0.0, 0.0, 0.0)))


def _body(number: int, point: Array) -> bytes:
    return struct.pack("<i", number) + _place(point) + struct.pack("<5fH", 0.0, 0.0, 0.0, 1.0, 1e-4, int(_seen(point)))


def _marker(number: int, point: Array, flags: int) -> bytes:
    hidden = 0 if _seen(point) else _OCCLUDED
    return struct.pack("<I", number) + _place(point) + struct.pack("<fHf", SIZE, flags | hidden, 2e-4)
