"""The frames of docs/serial.md: bytes that a page shows, and what is none."""

import random
import re
import struct

import pytest

from controller.drivers.valves.serial_board import frames
from controller.drivers.valves.serial_board.frames import Cutter, FrameError, HelloReply, State, VersionError
from controller.system.origin import ROOT
from tests.firmware.hostile import hostile, runs

pytestmark = pytest.mark.keyed("firmware", "docs/serial.md")

PAGE = (ROOT / "docs" / "serial.md").read_text()
STATE_BODY = struct.pack(
    "<BBHIIIHHBBBB4i", 1, 0x82, 8, 1_002_000, 500_123, 499_800, 3, 0, 0, 0, 4, 0, 149_500, 0, 12, -(2**31)
)
HELLO_BODY = struct.pack(
    "<BBHIIHHBBHiiI16s", 1, 0x81, 7, 10**6, 498_000, 256, 3, 4, 15, 100, 300_000, 340_000, 20_000_000, b"Arduino Uno"
)


def shown(name: str) -> bytes:
    """The bytes that the page shows after `name`."""
    block = PAGE[PAGE.index("## Bytes") :]
    found = re.search(rf"^{name} +((?:[0-9a-f]{{2}}\s+)+)", block, re.MULTILINE)
    assert found is not None
    return bytes.fromhex(found[1])


def test_a_hello_has_the_bytes_of_the_page() -> None:
    assert frames.hello(7, 1_000_000) == shown("hello")


def test_a_command_has_the_bytes_of_the_page() -> None:
    assert frames.command(8, 1_002_000, 0, 0b1001, [150_000, 0, 0, 20_000]) == shown("command")


def test_the_answers_of_the_page_are_read() -> None:
    hello, state = Cutter().feed(shown("its answer") + shown("state"))
    assert hello == HelloReply(7, 1_000_000, 498_000, 256, 3, 4, 15, 100, 300_000, 340_000, 20_000_000, "Arduino Uno")
    assert state == State(8, 1_002_000, 500_123, 499_800, 3, 0, 0, 0, (149_500, 0, 12, frames.BROKEN))


def test_the_checksum_is_the_one_that_the_page_names() -> None:
    assert frames.opened(frames.sealed(b"123456789").strip(b"\0")) == b"123456789"
    assert b"\xb1\x29" in frames.sealed(b"123456789")


@pytest.mark.parametrize("channels", [4, 16])
def test_frames_are_as_long_as_the_page_says(channels: int) -> None:
    state = struct.pack("<BBHIIIHHBBBB", 1, 0x82, 0, 0, 0, 0, 0, 0, 0, 0, channels, 0) + bytes(4 * channels)
    there, back = len(frames.command(0, 0, 0, 0, [0] * channels)), len(frames.sealed(state))
    assert (there, back) == {4: (33, 45), 16: (81, 93)}[channels]
    assert f"{there} {'bytes there and' if channels == 4 else 'and'}" in PAGE.replace("\n", " ")


def test_every_body_survives_stuffing() -> None:
    chance = random.Random(1)
    for size in range(1, 88):
        body = bytes(chance.choice((0, 0, 1, 255, chance.randrange(256))) for _ in range(size))
        assert frames.opened(frames.sealed(body).strip(b"\0")) == body


def test_frames_are_found_however_they_are_cut_into_pieces() -> None:
    wire, cutter = frames.sealed(STATE_BODY) * 50, Cutter()
    chance, found, at = random.Random(2), 0, 0
    while at < len(wire):
        size = chance.randint(1, 60)
        found += len(cutter.feed(wire[at : at + size]))
        at += size
    assert (found, cutter.rejected) == (50, 0)


def test_half_a_frame_costs_itself_only() -> None:
    cutter = Cutter()
    wire = frames.sealed(STATE_BODY)
    assert len(cutter.feed(wire[:20] + wire)) == 1
    assert cutter.rejected == 1


def test_bytes_without_an_end_are_not_kept() -> None:
    cutter = Cutter()
    for _ in range(1000):
        cutter.feed(b"\x01" * 1000)
    assert len(cutter._rest) < 100
    assert len(cutter.feed(b"\0" + frames.sealed(STATE_BODY))) == 1
    assert cutter.rejected == 1


def changed(body: bytes, at: int, *values: int) -> bytes:
    return body[:at] + bytes(values) + body[at + len(values) :]


WRONG = {
    "too short": b"\x01",
    "another version": changed(STATE_BODY, 0, 2),
    "a type of the host's": changed(STATE_BODY, 1, 2),
    "a length that is not that of its channels": STATE_BODY + b"\0\0\0\0",
    "no channel": changed(STATE_BODY, 22, 0),
    "17 channels": changed(STATE_BODY, 22, 17) + bytes(52),
    "an unknown reason": changed(STATE_BODY, 20, 0x40),
    "an unknown output": changed(STATE_BODY, 21, 0x10),
    "a byte that is kept free": changed(STATE_BODY, 23, 1),
    "a pressure of 200 MPa": changed(STATE_BODY, 24, 0, 0, 0, 0x0C),
    "a hello of no channels": changed(HELLO_BODY, 16, 0),
    "a hello with an unknown bit": changed(HELLO_BODY, 17, 0x10),
    "a name that cannot be read": changed(HELLO_BODY, 32, 7),
    "limits the wrong way round": changed(HELLO_BODY, 24, 1, 0, 0, 0),
    "a hello that is too long": HELLO_BODY + b"\0",
}


@pytest.mark.parametrize("body", WRONG.values(), ids=WRONG.keys())
def test_what_is_not_exactly_a_frame_is_refused(body: bytes) -> None:
    cutter = Cutter()
    assert cutter.feed(frames.sealed(body)) == []
    assert cutter.rejected == 1


def test_a_hello_of_another_version_is_told_apart() -> None:
    with pytest.raises(VersionError, match="the board speaks version 2 of the protocol, this driver version 1"):
        frames.decoded(changed(HELLO_BODY, 0, 2))


@pytest.mark.parametrize("body", [STATE_BODY, HELLO_BODY])
def test_a_mutated_body_is_read_whole_or_refused(body: bytes) -> None:
    chance = random.Random(3)
    for _ in range(20_000):
        at = chance.randrange(len(body))
        try:
            frames.decoded(changed(body, at, chance.randrange(256)))
        except FrameError:
            pass


def test_of_100_000_hostile_answers_each_is_counted() -> None:
    wrong = [body for name, body in WRONG.items() if name != "too short"]
    sound = frames.sealed(STATE_BODY)
    data = hostile(100_000, 4, lambda i: sound, lambda chance: chance.choice(wrong))
    cutter = Cutter()
    found = [frame for at in range(0, len(data), 997) for frame in cutter.feed(data[at : at + 997])]
    assert found == []
    assert cutter.rejected == runs(data) >= 100_000
