"""Messages that no page would send, from a seed: for the live socket, and for viser's."""

import json
from random import Random
from typing import Any

import msgpack

from server.scene.drag import CAMERA, END, START, UPDATE
from server.scene.scene import GIZMO

NUMBERS = (0, -1, 1e308, -1e308, float("nan"), float("inf"), 2**31, 2**63, -(2**64), 10**400, 1e-320, 0.1, 3)
ODD: tuple[Any, ...] = (*NUMBERS, None, True, "", "\0", "\u202e", "x" * 3000, [], {}, [[]], {"x": {}}, [None] * 500)
SHAPES: tuple[dict[str, Any], ...] = (
    {"type": "target", "id": 1, "x": 0.1, "y": 0.1, "start": True},
    {"type": "target", "id": 2, "x": 0.1, "y": 0.1},
    {"type": "release"},
    {"type": "presence", "n": 3},
    {"type": "ping", "t": 1.0, "round_trip": 0.1},
    {"type": "plots", "channels": ["energy"], "since": 1.0},
)
POSE = {"position": [0.1, 0.1, 0.0], "wxyz": [1.0, 0.0, 0.0, 0.0]}
VISER: tuple[dict[str, Any], ...] = (
    {"type": CAMERA, **POSE, "fov": 0.5, "near": 0.1, "far": 9.0, "look_at": [0, 0, 0], "up_direction": [0, 1, 0]},
    *({"type": kind, "name": GIZMO, "owner": "", **POSE} for kind in (START, UPDATE, END)),
    {"type": "GuiUpdateMessage", "uuid": "x", "updates": {"value": 1}},
    {"type": "ShareUrlRequest"},
)


def live_message(random: Random) -> tuple[bytes, bool]:
    """What goes on the live socket, and whether as text."""
    kind = random.randrange(12)
    if kind < 5:
        return _text(json.dumps(_bent(random, random.choice(SHAPES)))), True
    if kind < 7:
        return _text(json.dumps(random.choice(SHAPES))), True  # well formed, in any order
    if kind == 7:
        whole = json.dumps(random.choice(SHAPES))
        return _text(whole[: random.randrange(len(whole))]), True
    if kind == 8:
        depth = 10 ** random.randrange(1, 5)
        return _text(random.choice(("[", '{"type":', '{"type": "target", "x": [')) * (depth // 10)), True
    if kind == 9:
        return _text("".join(chr(random.choice((0, 34, 0x202E, 0x1F600, 0xFFFF, 0xE000))) for _ in range(50))), True
    if kind == 10:
        return random.randbytes(random.choice((0, 1, 100, 5000, 200_000))), False
    return _rare(random)


def viser_message(random: Random) -> tuple[bytes, bool]:
    """What goes on viser's socket, and whether as text."""
    kind = random.randrange(8)
    if kind < 4:
        return _packed(_bent(random, random.choice(VISER))), False
    if kind == 4:
        whole = _packed(random.choice(VISER))
        return whole[: random.randrange(len(whole))], False
    if kind == 5:
        return random.choice((b"\x91", b"\x81\xa1a", b"\xdf", b"\xc7\xff")) * random.randrange(1, 5000), False
    if kind == 6:
        return random.randbytes(random.choice((0, 1, 100, 20_000))), False
    return _rare(random)


def _bent(random: Random, shape: dict[str, Any]) -> dict[str, Any]:
    """`shape` with something else in one or two of its fields, or one too many or too few."""
    bent = dict(shape)
    for _ in range(random.randrange(1, 3)):
        field = random.choice([*bent, "more"]) if bent else "more"
        if random.randrange(6) == 0:
            bent.pop(field, None)
        else:
            bent[field] = random.choice(ODD)
    return bent


def _rare(random: Random) -> tuple[bytes, bool]:
    """Mostly what ends a socket: no Unicode, or far too long."""
    kind = random.randrange(20)
    if kind == 0:
        return b"x" * (3 << 20), True
    if kind < 4:
        return b"\xff\xfe\x80", True
    return _text('{"type": "ping", "t": 1.0, "t": 2.0, "type": "release"}'), True


def _text(text: str) -> bytes:
    return text.encode(errors="replace")


def _packed(value: Any) -> bytes:
    try:
        return bytes(msgpack.packb(value))
    except (OverflowError, ValueError):
        return bytes(msgpack.packb(str(value)))
