"""Frames that are none, of every kind that a line or a wrong program makes: the same ones for the same seed."""

import random
from collections.abc import Callable, Iterator

from controller.drivers.valves.serial_board.frames import sealed

Damage = Callable[[bytes, random.Random], bytes]


def flipped(wire: bytes, chance: random.Random) -> bytes:
    """One to three bits, which the checksum finds for certain unless they are in the stuffing."""
    damaged = bytearray(wire)
    for bit in chance.sample(range(8, 8 * (len(wire) - 1)), chance.randint(1, 3)):
        damaged[bit // 8] ^= 1 << bit % 8
    return bytes(damaged)


def burst(wire: bytes, chance: random.Random) -> bytes:
    """Some bytes in a row are others."""
    at, count = chance.randrange(1, len(wire) - 1), chance.randint(1, 8)
    return wire[:at] + chance.randbytes(count) + wire[at + count :]


def cut(wire: bytes, chance: random.Random) -> bytes:
    """Part of a frame."""
    return wire[: chance.randrange(2, len(wire) - 1)] + b"\0"


def missing(wire: bytes, chance: random.Random) -> bytes:
    """One byte was lost."""
    at = chance.randrange(1, len(wire) - 1)
    return wire[:at] + wire[at + 1 :]


def doubled(wire: bytes, chance: random.Random) -> bytes:
    """Two frames without the zeros between them."""
    return wire[:-1] + wire[1:]


def noise(wire: bytes, chance: random.Random) -> bytes:
    """Any bytes."""
    return b"\0" + chance.randbytes(chance.randint(1, 120)) + b"\0"


DAMAGES: tuple[Damage, ...] = (flipped, burst, cut, missing, doubled, noise)


def hostile(count: int, seed: int, sound: Callable[[int], bytes], wrong: Callable[[random.Random], bytes]) -> bytes:
    """`count` frames for the wire: half of them damaged ones of `sound(i)`, half well sealed bodies of `wrong`."""
    return b"".join(_frames(count, random.Random(seed), sound, wrong))


def _frames(
    count: int, chance: random.Random, sound: Callable[[int], bytes], wrong: Callable[[random.Random], bytes]
) -> Iterator[bytes]:
    for i in range(count):
        if i % 2:
            yield sealed(wrong(chance))
            continue
        wire = sound(i)
        damaged = chance.choice(DAMAGES)(wire, chance)
        yield damaged if damaged != wire else cut(wire, chance)


def runs(data: bytes) -> int:
    """Frames in `data`, of whatever kind: what stands between zeros."""
    return sum(1 for part in data.split(b"\0") if part)
