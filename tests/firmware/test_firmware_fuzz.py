"""Hostile frames through the firmware's core, with the compiler's own checks for memory and arithmetic."""

import random
import struct
import subprocess
from pathlib import Path

import pytest

from controller.drivers.valves.serial_board import frames
from controller.virtual.firmware import FLAGS, build, firmware_folder
from tests.firmware.hostile import hostile, runs

pytestmark = [pytest.mark.process, pytest.mark.keyed("firmware")]

CHANNELS = 8
SEQUENCE = 2000
"""Newer than what the fuzzed board has taken: a sound frame would act."""
CHECKS = ("-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")


@pytest.fixture(scope="module")
def fuzzer(tmp_path_factory: pytest.TempPathFactory) -> Path:
    program = tmp_path_factory.mktemp("firmware") / "fuzz"
    build(firmware_folder() / "host" / "fuzz.cpp", program, (*FLAGS, "-Werror", *CHECKS))
    return program


def fed(fuzzer: Path, data: bytes) -> tuple[int, int]:
    """What the board refused, and after how many bytes something had moved."""
    done = subprocess.run([fuzzer], input=data, capture_output=True, timeout=60)
    assert done.returncode == 0, done.stderr.decode()
    words = done.stdout.split()
    return int(words[1]), int(words[3])


def sound(i: int) -> bytes:
    return frames.command(SEQUENCE, i, 0, 0xFF, [250_000 + i % 1000] * CHANNELS)


def body(
    version: int = 1, kind: int = 2, sequence: int = SEQUENCE, wanted: int = 0, channels: int = CHANNELS,
    driven: int = 0xFF, target: int = 250_000, count: int = CHANNELS,
) -> bytes:  # fmt: skip
    head = struct.pack("<BBHIBBH", version, kind, sequence, 0, wanted, channels, driven)
    return head + struct.pack(f"<{count}i", *[target] * count)


def wrong(chance: random.Random) -> bytes:
    """Well sealed, and wrong in one way."""
    return chance.choice(WRONG)(chance)


WRONG = (
    lambda c: body(version=c.choice((0, *range(2, 256)))),
    lambda c: body(kind=c.choice((0, 1, *range(3, 256)))),
    lambda c: body(sequence=1050 - c.randrange(30_000) & 0xFFFF),
    lambda c: body(wanted=c.randrange(8, 256)),
    lambda c: body(channels=c.choice((*range(8), *range(9, 256)))),
    lambda c: body(driven=c.randrange(0x100, 0x10000)),
    lambda c: body(driven=c.randrange(0xFF)),
    lambda c: body(target=c.choice((-1, 1)) * c.randrange(1_200_001, 2**31)),
    lambda c: body(wanted=4, target=c.choice((-1, 1)) * c.randrange(32_768, 2**31)),
    lambda c: body(count=c.choice((*range(8), *range(9, 20)))),
    lambda c: body()[: c.randrange(1, 44)],
    lambda c: c.randbytes(c.randrange(1, 88)),
)


def test_a_sound_frame_moves_the_fuzzed_board(fuzzer: Path) -> None:
    refused, moved = fed(fuzzer, sound(0) + b"\x01" * 200)
    assert refused == 0
    assert moved > 0


def test_of_100_000_hostile_frames_each_is_counted_and_nothing_moves(fuzzer: Path) -> None:
    data = hostile(100_000, 5, sound, wrong)
    refused, moved = fed(fuzzer, data)
    assert moved == 0
    assert refused == runs(data) >= 100_000


def test_a_hello_of_another_version_moves_nothing(fuzzer: Path) -> None:
    assert fed(fuzzer, frames.sealed(struct.pack("<BBHI", 2, 1, 0, 0))) == (1, 0)
