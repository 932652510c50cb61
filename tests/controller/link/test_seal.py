"""The seal alone: what a stranger can record, change or send again, and what a key file must be."""

import os
import stat
from pathlib import Path

import pytest

from controller.errors import KeyRefused, LayoutMismatch, ParameterError, RigHeld, SessionUnknown
from controller.link.refusals import QUIET_S, Refusals
from controller.link.seal import SESSIONS_MAX, SILENT_S, Holder, Introduction, SealedSession, Sealer, Seals
from controller.link.version import OURS
from controller.system.keys import KEY_BYTES, key_path, made_key, read_key

KEY, OTHER = b"k" * KEY_BYTES, b"o" * KEY_BYTES
SESSION, COMMAND, PLAN = "tendril/twin/session", "tendril/twin/command", "tendril/twin/reference"
FILE = "/rig/twin.key"
ME = Introduction(who="the server on desk (process 7)").model_dump_json().encode()


def opened(seals: Seals, key: bytes = KEY) -> Sealer:
    sealer = Sealer(key, seals.boot, seals.next_session)
    seals.open(SESSION, ME, sealer.seal(SESSION, ME))
    return sealer


def test_a_sealed_message_is_taken_once_and_in_order() -> None:
    seals = Seals(KEY, 7, FILE)
    sealer = opened(seals)
    first, second, third = (sealer.seal(COMMAND, b"go") for _ in range(3))
    assert seals.admit(COMMAND, b"go", first).who == "the server on desk (process 7)"
    assert seals.admit(COMMAND, b"go", third)
    for old in (first, second, third):
        with pytest.raises(KeyRefused, match=r"count \d of this session is not above 3"):
            seals.admit(COMMAND, b"go", old)
    assert seals.admit(PLAN, b"path", sealer.seal(PLAN, b"path"))


def test_no_bit_of_a_sealed_message_can_be_changed() -> None:
    seals = Seals(KEY, 7, FILE)
    sealer = opened(seals)
    seal = sealer.seal(COMMAND, b"go")
    for place in range(8, len(seal)):  # the first eight bytes are the session, which is then unknown
        changed = bytearray(seal)
        changed[place] ^= 1
        with pytest.raises(KeyRefused, match="sealed with another key"):
            seals.admit(COMMAND, b"go", bytes(changed))
    with pytest.raises(KeyRefused, match="sealed with another key"):
        seals.admit(COMMAND, b"no", seal)
    with pytest.raises(KeyRefused, match="sealed with another key"):
        seals.admit(PLAN, b"go", seal)
    assert seals.admit(COMMAND, b"go", seal)


def test_a_recorded_message_is_worth_nothing_in_another_life_of_the_rig() -> None:
    last, boot = Seals(KEY, 7, FILE), Seals(KEY, 8, FILE)
    old = opened(last)
    with pytest.raises(SessionUnknown):
        boot.admit(COMMAND, b"go", old.seal(COMMAND, b"go"))
    number = opened(boot).session
    with pytest.raises(KeyRefused, match="another key"):  # nor under a number that this boot knows
        boot.admit(COMMAND, b"go", Sealer(KEY, 7, number).seal(COMMAND, b"go"))
    with pytest.raises(KeyRefused, match="another key"):
        boot.open(SESSION, ME, Sealer(KEY, 7, boot.next_session).seal(SESSION, ME))


def test_an_opening_is_taken_once_even_if_it_was_refused() -> None:
    seals = Seals(KEY, 7, FILE)
    foreign = Introduction(who="an old server", version="0.0.1", layout="0123456789abcdef").model_dump_json().encode()
    seal = Sealer(KEY, 7, seals.next_session).seal(SESSION, foreign)
    with pytest.raises(
        LayoutMismatch, match=rf"an old server is Tendril 0\.0\.1 .*0123456789abcdef, this rig .*{OURS}"
    ):
        seals.open(SESSION, foreign, seal)
    with pytest.raises(SessionUnknown, match="cannot be opened any more"):
        seals.open(SESSION, foreign, seal)
    with pytest.raises(ParameterError, match="introduction"):
        seals.open(SESSION, b"{}", Sealer(KEY, 7, seals.next_session).seal(SESSION, b"{}"))


def test_a_missing_or_foreign_seal_is_told_which_file_holds_the_key() -> None:
    seals = Seals(KEY, 7, FILE)
    number = opened(seals).session
    with pytest.raises(KeyRefused, match=f"a seal of 0 bytes .*{FILE}"):
        seals.admit(COMMAND, b"go", b"")
    with pytest.raises(KeyRefused, match=f"copy {FILE}"):
        seals.admit(COMMAND, b"go", Sealer(OTHER, 7, number).seal(COMMAND, b"go"))
    with pytest.raises(KeyRefused, match=f"copy {FILE}"):
        opened(seals, OTHER)


def test_the_server_that_was_silent_longest_is_forgotten_first() -> None:
    seals = Seals(KEY, 7, FILE)
    first, second = opened(seals), opened(seals)
    seals.admit(COMMAND, b"go", first.seal(COMMAND, b"go"))
    for _ in range(SESSIONS_MAX - 1):
        opened(seals)
    assert seals.admit(COMMAND, b"go", first.seal(COMMAND, b"go"))
    with pytest.raises(SessionUnknown):
        seals.admit(COMMAND, b"go", second.seal(COMMAND, b"go"))


def test_the_first_server_commands_until_it_leaves_or_was_silent() -> None:
    clock = [100.0]
    holder, first, second = (
        Holder(lambda: clock[0]),
        SealedSession(1, "the server on a"),
        SealedSession(2, "the server on b"),
    )
    holder.take(first)
    clock[0] += 0.9 * SILENT_S
    holder.take(first)
    clock[0] += 0.9 * SILENT_S
    with pytest.raises(RigHeld, match=r"the server on a commands this rig since \d{4}-\d\d-\d\d \d\d:\d\d:\d\d"):
        holder.take(second)
    holder.leave(second)
    with pytest.raises(RigHeld):
        holder.take(second)
    clock[0] += 0.2 * SILENT_S
    holder.take(second)
    with pytest.raises(RigHeld, match="the server on b"):
        holder.take(first)
    holder.leave(second)
    holder.take(first)


def test_refusals_are_all_counted_and_rarely_logged(caplog: pytest.LogCaptureFixture) -> None:
    clock = [0.0]
    refusals = Refusals("twin", lambda: clock[0])
    for _ in range(500):
        refusals.note(COMMAND, KeyRefused("no seal"))
    assert (refusals.count, len(caplog.records)) == (500, 1)
    clock[0] += QUIET_S
    refusals.note(PLAN, KeyRefused("no seal"))
    assert [record.getMessage() for record in caplog.records][1:] == [
        "rig twin, query on tendril/twin/reference: no seal (501 refused since the start)"
    ]


def test_a_key_is_made_once_for_the_user_alone(tmp_path: Path) -> None:
    path = key_path("twin", tmp_path / "state")
    key = made_key(path)
    assert len(key) == KEY_BYTES
    assert made_key(path) == read_key(path) == key
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert made_key(tmp_path / "other.key") != key


def test_a_key_file_that_others_can_use_or_that_holds_no_key_is_named(tmp_path: Path) -> None:
    path = tmp_path / "twin.key"
    made_key(path)
    for mode in (0o640, 0o604, 0o620):
        path.chmod(mode)
        with pytest.raises(KeyRefused, match=rf"twin\.key has mode {mode:04o}, .*chmod 600"):
            read_key(path)
    path.chmod(0o600)
    for text in (b"", b"not base64!", b"c2hvcnQ=", os.urandom(5000)):
        path.write_bytes(text)
        with pytest.raises(KeyRefused, match=r"twin\.key does not hold 32 bytes in base64"):
            read_key(path)
    with pytest.raises(KeyRefused, match=r"none\.key does not exist"):
        read_key(tmp_path / "none.key")
    with pytest.raises(KeyRefused, match=r"inside\.key cannot be"):
        made_key(path / "inside.key")
