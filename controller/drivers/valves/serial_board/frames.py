"""The frames of docs/serial.md: numbers to bytes and back. Whatever is not exactly a frame raises FrameError."""

import struct
from binascii import crc_hqx
from collections.abc import Sequence
from typing import NamedTuple

from controller.errors import TendrilError

PROTOCOL = 1
HELLO, COMMAND, HELLO_REPLY, STATE = 0x01, 0x02, 0x81, 0x82
VENT, CUT, RAW = 1, 2, 4
"""What a command wants."""
BOOT, GREETED, WATCHDOG, OVER_PRESSURE, E_STOP_INPUT, BROKEN_SENSOR = 1, 2, 4, 8, 16, 32
"""Why a board drives nothing."""
VENTED, SUPPLY_CUT, TAKES_RAW, LIMITED = 1, 2, 4, 8
"""What its outputs do."""
HOLDS_PRESSURE, TAKES_OPENINGS, CUTS_SUPPLY, HAS_E_STOP_INPUT = 1, 2, 4, 8
"""What a board can do."""
SETPOINT_END = 1_200_000
"""Beyond it a setpoint is nonsense on any board [Pa]."""
PRESSURE_END = 10_000_000
"""Beyond it a reading is none [Pa]."""
OPENING_END = 32767
"""A valve that is fully open."""
BROKEN = -(2**31)
"""Instead of a pressure: the sensor is broken."""
CHANNELS_MAX = 16
FRAME_MAX_BYTES = 24 + 4 * CHANNELS_MAX + 2
"""Bytes of the longest frame, with its checksum."""

_HEAD = struct.Struct("<BBHI")
_COMMAND = struct.Struct("<BBHIBBH")
_HELLO_REPLY = struct.Struct("<BBHIIHHBBHiiI16s")
_STATE = struct.Struct("<BBHIIIHHBBBB")
_CRC = struct.Struct("<H")
_TARGETS = [struct.Struct(f"<{count}i") for count in range(CHANNELS_MAX + 1)]


class FrameError(TendrilError):
    """These bytes are no frame of this protocol; the text says why."""


class VersionError(FrameError):
    """A board that greets in another version."""


class HelloReply(NamedTuple):
    """What a board is; times in microseconds of its clock, which wraps."""

    sequence: int
    host_us: int
    """As the host sent it."""
    received_us: int
    """When the host's frame was there."""
    firmware: int
    """major << 8 | minor."""
    boot: int
    """Rises each time the board starts."""
    channels: int
    capabilities: int
    watchdog_ms: int
    pressure_max: int
    """Largest setpoint it follows [Pa]."""
    pressure_trip: int
    """Above it the board vents and cuts the supply [Pa]."""
    slew_max: int
    """[Pa/s]."""
    name: str


class State(NamedTuple):
    """A board's answer to a command."""

    sequence: int
    host_us: int
    received_us: int
    read_us: int
    """When the pressures were read."""
    boot: int
    rejected: int
    """Frames that the board refused since it started, modulo 65536."""
    stopped: int
    """BOOT to BROKEN_SENSOR; 0: it obeys."""
    outputs: int
    """VENTED to LIMITED."""
    pressures: tuple[int, ...]
    """Gauge, of every channel [Pa], or BROKEN."""


def hello(sequence: int, host_us: int) -> bytes:
    """Ask a board what it is; bytes for the wire."""
    return sealed(_HEAD.pack(PROTOCOL, HELLO, sequence, host_us))


def command(sequence: int, host_us: int, wanted: int, driven: int, targets: Sequence[int]) -> bytes:
    """Tell every channel its target: [Pa], or openings in 1/32767 where `wanted` has RAW; bytes for the wire.

    `driven` has a bit for each channel that is driven; the others are vented, and their targets must be 0.
    """
    head = _COMMAND.pack(PROTOCOL, COMMAND, sequence, host_us, wanted, len(targets), driven)
    return sealed(head + _TARGETS[len(targets)].pack(*targets))


def sealed(body: bytes) -> bytes:
    """`body` with its checksum, stuffed, between two zeros; at most 252 bytes."""
    whole = body + _CRC.pack(crc_hqx(body, 0xFFFF))
    return b"\0" + b"".join(bytes((len(part) + 1,)) + part for part in whole.split(b"\0")) + b"\0"


def opened(stuffed: bytes) -> bytes:
    """What stood between two zeros, without stuffing and checksum; FrameError where it is damaged."""
    if len(stuffed) > FRAME_MAX_BYTES + 1:
        raise FrameError(f"{len(stuffed)} bytes without a zero, at most {FRAME_MAX_BYTES + 1} are a frame")
    parts, at = [], 0
    while at < len(stuffed):
        code = stuffed[at]
        if code in (0, 0xFF) or at + code > len(stuffed):
            raise FrameError(f"stuffing: code {code} at byte {at} of {len(stuffed)}")
        parts.append(stuffed[at + 1 : at + code])
        at += code
    whole = b"\0".join(parts)
    if len(whole) <= _CRC.size or crc_hqx(whole[:-2], 0xFFFF) != _CRC.unpack(whole[-2:])[0]:
        raise FrameError("the checksum is wrong")
    return whole[:-2]


def decoded(body: bytes) -> HelloReply | State:
    """The board's frame in `body`; FrameError where anything in it is not as docs/serial.md says."""
    if len(body) < 2:
        raise FrameError(f"{len(body)} bytes are no frame")
    if body[1] == HELLO_REPLY and body[0] != PROTOCOL:
        raise VersionError(f"the board speaks version {body[0]} of the protocol, this driver version {PROTOCOL}")
    if body[0] != PROTOCOL or body[1] not in (HELLO_REPLY, STATE):
        raise FrameError(f"version {body[0]}, type {body[1]:#x} is no answer of a board")
    return _hello_reply(body) if body[1] == HELLO_REPLY else _state(body)


def _hello_reply(body: bytes) -> HelloReply:
    if len(body) != _HELLO_REPLY.size:
        raise FrameError(f"a hello of {len(body)} bytes, not {_HELLO_REPLY.size}")
    *numbers, name = _HELLO_REPLY.unpack(body)
    found = HelloReply._make((*numbers[2:], name.rstrip(b"\0").decode("ascii", "replace")))
    if not 1 <= found.channels <= CHANNELS_MAX:
        raise FrameError(f"channels = {found.channels} is outside [1, {CHANNELS_MAX}]")
    if found.capabilities & ~0x0F or not found.name.isprintable() or not found.name.isascii():
        raise FrameError("a hello with unknown bits or an unreadable name")
    if not 0 < found.pressure_max <= found.pressure_trip <= PRESSURE_END:
        raise FrameError(f"limits of {found.pressure_max} and {found.pressure_trip} Pa")
    return found


def _state(body: bytes) -> State:
    if len(body) < _STATE.size:
        raise FrameError(f"a state of {len(body)} bytes")
    *numbers, stopped, outputs, channels, reserved = _STATE.unpack_from(body)
    if not 1 <= channels <= CHANNELS_MAX or len(body) != _STATE.size + 4 * channels:
        raise FrameError(f"a state of {len(body)} bytes for {channels} channels")
    if stopped & ~0x3F or outputs & ~0x0F or reserved:
        raise FrameError("a state with unknown bits")
    pressures = _TARGETS[channels].unpack_from(body, _STATE.size)
    if any(not -PRESSURE_END <= pressure <= PRESSURE_END and pressure != BROKEN for pressure in pressures):
        raise FrameError(f"pressures of {list(pressures)} Pa")
    return State._make((*numbers[2:], stopped, outputs, pressures))


class Cutter:
    """Cuts what arrives at zeros: whatever came before, the next zero begins again."""

    def __init__(self) -> None:
        self.rejected = 0
        """Runs of bytes between zeros that were no frame."""
        self._rest = b""

    def feed(self, data: bytes) -> list[HelloReply | State]:
        """The board's whole frames that end in `data`. Raises VersionError, and what came with it is lost."""
        *ended, self._rest = (self._rest + data).split(b"\0")
        self._rest = self._rest[: FRAME_MAX_BYTES + 2]  # enough to know that it is too long
        return [frame for stuffed in ended if stuffed and (frame := self._frame(stuffed))]

    def _frame(self, stuffed: bytes) -> HelloReply | State | None:
        try:
            return decoded(opened(stuffed))
        except FrameError as error:
            self.rejected += 1
            if isinstance(error, VersionError):
                raise
            return None
