"""The two datagrams between us and a Simulink or LabVIEW target (docs/udp.md): fixed size, little endian, no gaps."""

import struct
import zlib
from typing import NamedTuple

VERSION = 1
COMMAND_MAGIC, REPLY_MAGIC = 0x43524454, 0x52524454
"""As bytes: "TDRC", "TDRR"."""
PRESSURE_FAR = 1e7
"""No pressure is beyond this [Pa]; nan is a broken sensor."""

VENT, CUT, RAW = 1, 2, 4
"""Flags of a command: open every chamber, cut the supply, follow openings instead of pressures."""
WATCHDOG, LIMIT = 1, 2
"""Flags of a reply: the target vents because no command came, or a pressure was above its own limit."""

HEAD = (("magic", "I", 1), ("version", "B", 1), ("flags", "B", 1), ("size", "H", 1), ("sequence", "I", 1))
COMMAND_FIELDS = (
    *HEAD,
    ("session", "I", 1),
    ("time", "q", 1),
    ("pressures", "d", 4),
    ("openings", "d", 4),
    ("reserved", "I", 1),
    ("check", "I", 1),
)
REPLY_FIELDS = (
    *HEAD,
    ("session", "I", 1),
    ("time", "q", 1),
    ("replied", "q", 1),
    ("read", "q", 1),
    ("pressures", "d", 4),
    ("number", "I", 1),
    ("check", "I", 1),
)
"""Name, kind as struct names it, count."""


def _packing(fields: tuple[tuple[str, str, int], ...]) -> struct.Struct:
    return struct.Struct("<" + "".join(f"{count}{kind}" for _, kind, count in fields))


COMMAND, REPLY = _packing(COMMAND_FIELDS), _packing(REPLY_FIELDS)


class Command(NamedTuple):
    """What the valves are to do."""

    flags: int
    sequence: int
    session: int
    """Drawn again whenever we open the target: a target takes no old command of another."""
    time: int
    """When it was sent, on our clock [ns]; a target sends it back."""
    pressures: tuple[float, ...]
    """By channel [Pa]."""
    openings: tuple[float, ...]
    """By channel, -1 to 1."""


class Reply(NamedTuple):
    """What the target says: sequence, session and time are those of the command."""

    flags: int
    sequence: int
    session: int
    time: int
    replied: int
    """When it replied, on its clock [ns]."""
    read: int
    """When it read the pressures, on its clock [ns]."""
    pressures: tuple[float, ...]
    """By channel [Pa]; nan for a broken sensor."""
    number: int
    """Its own count of replies."""


def check_of(data: bytes) -> int:
    """CRC-32 of IEEE 802.3 over all but the last word: UDP's own sum misses much, and some switch it off."""
    return zlib.crc32(data[:-4])


def pack_command(command: Command) -> bytes:
    """The datagram of `command`."""
    flags, sequence, session, time, pressures, openings = command
    head = (COMMAND_MAGIC, VERSION, flags, COMMAND.size, sequence & 0xFFFFFFFF, session, time)
    return _checked(COMMAND.pack(*head, *pressures, *openings, 0, 0))


def pack_reply(reply: Reply) -> bytes:
    """The datagram of `reply`."""
    flags, sequence, session, time, replied, read, pressures, number = reply
    head = (REPLY_MAGIC, VERSION, flags, REPLY.size, sequence, session, time, replied, read)
    return _checked(REPLY.pack(*head, *pressures, number & 0xFFFFFFFF, 0))


def unpack_command(data: bytes) -> Command | None:
    """What `data` commands; None if it is no such datagram, or holds a number that no valve could follow."""
    if not _whole(data, COMMAND, COMMAND_MAGIC):
        return None
    _, _, flags, _, sequence, session, time, *values, reserved, _ = COMMAND.unpack(data)
    found = Command(flags, sequence, session, time, tuple(values[:4]), tuple(values[4:]))
    small = all(abs(value) <= PRESSURE_FAR for value in found.pressures)  # nan is not
    whole = small and all(abs(value) <= 1.0 for value in found.openings)
    return found if whole and flags < 8 and reserved == 0 else None


def unpack_reply(data: bytes) -> Reply | None:
    """What `data` says; None if it is no such datagram, or holds impossible numbers."""
    if not _whole(data, REPLY, REPLY_MAGIC):
        return None
    _, _, flags, _, sequence, session, time, replied, read, *pressures, number, _ = REPLY.unpack(data)
    likely = not any(abs(value) > PRESSURE_FAR for value in pressures) and 0 <= replied - read <= 1_000_000_000
    return Reply(flags, sequence, session, time, replied, read, tuple(pressures), number) if likely else None


def _whole(data: bytes, packing: struct.Struct, magic: int) -> bool:
    if len(data) != packing.size:
        return False
    found, version, _, size = struct.unpack_from("<IBBH", data)
    known = (found, version, size) == (magic, VERSION, packing.size)
    return known and check_of(data) == int.from_bytes(data[-4:], "little")


def _checked(data: bytes) -> bytes:
    return data[:-4] + check_of(data).to_bytes(4, "little")
