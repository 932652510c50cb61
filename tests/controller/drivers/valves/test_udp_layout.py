import random
import re
import shutil
import struct
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from controller.drivers.valves.udp_layout import (
    COMMAND,
    COMMAND_FIELDS,
    COMMAND_MAGIC,
    REPLY,
    REPLY_FIELDS,
    REPLY_MAGIC,
    Command,
    Reply,
    pack_command,
    pack_reply,
    unpack_command,
    unpack_reply,
)
from controller.system.origin import ROOT

ROUNDS = 100_000
PAGE = (ROOT / "docs" / "udp.md").read_text()
WORDS = {"I": "uint32", "B": "uint8", "H": "uint16", "q": "int64", "d": "double"}
COMMAND_SENT = Command(0, 41, 0xDEADBEEF, 123_456_789_012, (1e5, 0.0, -2e4, 3.5), (0.0, 1.0, -1.0, 0.25))
REPLY_SENT = Reply(1, 41, 0xDEADBEEF, 123_456_789_012, 77_000_000, 76_000_000, (1e5, 0.0, -2e4, 3.5), 12)


def places(fields: tuple[tuple[str, str, int], ...]) -> dict[str, tuple[int, int, str]]:
    """Name of a field to offset, end and type."""
    found, at = {}, 0
    for name, kind, count in fields:
        size = struct.calcsize(f"<{count}{kind}")
        found[name] = (at, at + size, WORDS[kind])
        at += size
    return found


def snippet(name: str) -> str:
    found = re.search(rf"<!-- {name}\.m -->\n```matlab\n(.*?)```", PAGE, re.DOTALL)
    assert found
    return found[1]


def test_datagrams_come_back_as_they_were() -> None:
    assert unpack_command(pack_command(COMMAND_SENT)) == COMMAND_SENT
    assert unpack_reply(pack_reply(REPLY_SENT)) == REPLY_SENT
    assert (COMMAND.size, REPLY.size) == (96, 80)
    assert pack_command(COMMAND_SENT)[:4] == b"TDRC" and pack_reply(REPLY_SENT)[:4] == b"TDRR"


def test_a_broken_sensor_is_nan_and_nothing_else_may_be() -> None:
    broken = unpack_reply(pack_reply(REPLY_SENT._replace(pressures=(1.0, np.nan, 2.0, 3.0))))
    assert broken is not None and np.isnan(broken.pressures[1])
    assert unpack_reply(pack_reply(REPLY_SENT._replace(pressures=(1.0, np.inf, 2.0, 3.0)))) is None
    assert unpack_reply(pack_reply(REPLY_SENT._replace(read=78_000_000))) is None  # read after it was sent
    for value in (np.nan, np.inf, 1e9):
        assert unpack_command(pack_command(COMMAND_SENT._replace(pressures=(value, 0.0, 0.0, 0.0)))) is None
        assert unpack_command(pack_command(COMMAND_SENT._replace(openings=(value, 0.0, 0.0, 0.0)))) is None


@pytest.mark.parametrize(("fields", "title"), [(COMMAND_FIELDS, "## Command"), (REPLY_FIELDS, "## Reply")])
def test_the_page_names_each_field_at_its_offset(fields: tuple[tuple[str, str, int], ...], title: str) -> None:
    table = PAGE[PAGE.index(title) :].split("\n## ")[0] if title == "## Reply" else PAGE[PAGE.index(title) :]
    rows = re.findall(r"^\| (\d+) \| (\w+?)(?:\[(\d)\])? \| `(\w+)` \|", table, re.MULTILINE)[: len(fields)]
    wanted = places(fields)
    assert [name for *_, name in rows] == [name for name, *_ in fields]
    for at, kind, count, name in rows:
        size = struct.calcsize("<" + (count or "1") + next(letter for letter, word in WORDS.items() if word == kind))
        assert (int(at), int(at) + size, kind) == wanted[name]


def test_the_snippets_know_each_field_at_its_offset() -> None:
    """Their indices begin with 1 and include the end: the numbers in the text are compared with the struct."""
    taken = re.findall(r"^  (\w+)\s*= typecast\(d\((\d+):(\d+)\), '(\w+)'\);", snippet("tendril_command"), re.MULTILINE)
    found = {name.rstrip("_"): (int(a) - 1, int(b), kind) for name, a, b, kind in taken}
    assert re.search(r"^  version\s*= d\(5\);\n  flags\s*= d\(6\);", snippet("tendril_command"), re.MULTILINE)
    assert found | {"version": (4, 5, "uint8"), "flags": (5, 6, "uint8")} == places(COMMAND_FIELDS)
    put = re.findall(
        r"^  d\((\d+)(?::(\d+))?\)\s*= (?:typecast\((\w+)\(.*\), 'uint8'\)|1|uint8\(flags\));\s*% (\w+)$",
        snippet("tendril_reply"),
        re.MULTILINE,
    )
    packed = {name: (int(a) - 1, int(b or a), kind or "uint8") for a, b, kind, name in put}
    assert packed == places(REPLY_FIELDS)


def test_the_snippets_know_magic_sizes_and_check() -> None:
    command, reply = snippet("tendril_command"), snippet("tendril_reply")
    assert str(COMMAND_MAGIC) in command and str(REPLY_MAGIC) in reply
    assert f"tendril_crc(d(1:{COMMAND.size - 4}))" in command and f"tendril_crc(d(1:{REPLY.size - 4}))" in reply
    assert f"size_ == {COMMAND.size}" in command and f"zeros(1, {REPLY.size}, 'uint8')" in reply
    assert str(COMMAND_MAGIC) in PAGE and str(REPLY_MAGIC) in PAGE


@pytest.mark.skipif(shutil.which("octave-cli") is None, reason="GNU Octave is not here")
def test_the_snippets_run_in_octave_and_agree_with_us(tmp_path: Path) -> None:
    for name in ("tendril_command", "tendril_reply", "tendril_crc"):
        (tmp_path / f"{name}.m").write_text(snippet(name))
    (tmp_path / "command.bin").write_bytes(pack_command(COMMAND_SENT))
    (tmp_path / "run.m").write_text(
        "d = fread(fopen('command.bin'), 96, '*uint8');\n"
        "[ok, flags, sequence, session, time, pressures, openings] = tendril_command(d);\n"
        "d(30) = bitxor(d(30), 4); wrong = tendril_command(d);\n"
        "printf('%d %d %d %d %d %d', ok, wrong, flags, sequence, session, time);\n"
        "printf(' %.17g', pressures, openings);\n"
        f"fwrite(fopen('reply.bin', 'w'), tendril_reply(1, sequence, session, time, {REPLY_SENT.replied},"
        f" {REPLY_SENT.read}, pressures, {REPLY_SENT.number}));\n"
    )
    done = subprocess.run(
        ["octave-cli", "--no-gui", "--norc", "run.m"], cwd=tmp_path, capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
    sent = COMMAND_SENT
    numbers = [1, 0, sent.flags, sent.sequence, sent.session, sent.time, *sent.pressures, *sent.openings]
    assert [float(word) for word in done.stdout.split()] == numbers
    assert unpack_reply((tmp_path / "reply.bin").read_bytes()) == REPLY_SENT


@pytest.mark.parametrize("reply", [False, True])
def test_no_mutated_datagram_is_taken(reply: bool) -> None:
    data = pack_reply(REPLY_SENT) if reply else pack_command(COMMAND_SENT)
    unpack: Callable[[bytes], object] = unpack_reply if reply else unpack_command
    rng = random.Random(21)
    for _ in range(ROUNDS):
        other = mutated(rng, data)
        assert other == data or unpack(other) is None


def mutated(rng: random.Random, data: bytes) -> bytes:
    kind = rng.randrange(6)
    if kind == 0:
        return rng.randbytes(rng.randrange(0, 200))
    if kind == 1:
        return data[: rng.randrange(len(data))] + rng.randbytes(rng.randrange(2))
    out = bytearray(data)
    for _ in range(rng.randrange(1, 5)):
        at = rng.randrange(len(out))
        if kind == 2:
            out[at] ^= 1 << rng.randrange(8)
        elif kind == 3:
            out[at] = rng.randrange(256)
        elif kind == 4:
            other = rng.randrange(len(out))
            out[at], out[other] = out[other], out[at]
        else:
            out[at : at + 8] = struct.pack("<d", rng.choice([np.nan, np.inf, 1e300, -1e12]))[: len(out[at : at + 8])]
    return bytes(out)
