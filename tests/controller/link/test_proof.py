"""Proofs alone: what a stranger can record, change or send again; and the pace of telemetry."""

import numpy as np
import pytest

from controller.errors import Unproven
from controller.link.proof import Prover, question, read_batch, read_reply
from controller.link.stream import SLACK_S, Pace
from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.system.keys import KEY_BYTES

KEY, OTHER = b"k" * KEY_BYTES, b"o" * KEY_BYTES
TELEMETRY, COMMAND = "tendril/twin/telemetry", "tendril/twin/command"


def test_a_batch_says_its_life_and_its_number() -> None:
    prover = Prover(KEY, 7)
    first, second = (prover.batch(TELEMETRY, b"rows") for _ in range(2))
    assert read_batch(KEY, TELEMETRY, first, b"rows") == (7, 1)
    assert read_batch(KEY, TELEMETRY, second, b"rows") == (7, 2)


def test_no_bit_of_a_batch_can_be_changed() -> None:
    proof = Prover(KEY, 7).batch(TELEMETRY, b"rows")
    for place in range(len(proof)):
        changed = bytearray(proof)
        changed[place] ^= 1
        with pytest.raises(Unproven, match="not made with the rig's key"):
            read_batch(KEY, TELEMETRY, bytes(changed), b"rows")
    for key, expression, payload in ((OTHER, TELEMETRY, b"rows"), (KEY, COMMAND, b"rows"), (KEY, TELEMETRY, b"rowz")):
        with pytest.raises(Unproven, match="not made with the rig's key"):
            read_batch(key, expression, proof, payload)
    for wrong in (b"", proof[:-1], proof + b"x"):
        with pytest.raises(Unproven, match=f"a proof of {len(wrong)} bytes is not one of 48"):
            read_batch(KEY, TELEMETRY, wrong, b"rows")


def test_a_reply_answers_one_question_and_says_what_it_is() -> None:
    prover = Prover(KEY, 7)
    prover.batch(TELEMETRY, b"rows")
    asked = question(b"number", b"who")
    proof = prover.reply(COMMAND, asked, b"no", "RigHeld")
    found = read_reply(KEY, COMMAND, asked, proof, b"no")
    assert (found.boot, found.sent, found.kind) == (7, 1, "RigHeld")
    others = (question(b"numbes", b"who"), question(b"number", b"whom"), question(b"numberw", b"ho"))
    for other in others:
        with pytest.raises(Unproven, match="not for this"):
            read_reply(KEY, COMMAND, other, proof, b"no")
    for place in range(len(proof)):
        changed = bytearray(proof)
        changed[place] ^= 1
        with pytest.raises(Unproven):
            read_reply(KEY, COMMAND, asked, bytes(changed), b"no")
    for expression, payload, wrong in (
        (TELEMETRY, b"no", proof),
        (COMMAND, b"yes", proof),
        (COMMAND, b"no", proof[:56]),
    ):
        with pytest.raises(Unproven):
            read_reply(KEY, expression, asked, wrong, payload)
    with pytest.raises(Unproven, match="is not one of 56 to 96"):
        read_reply(KEY, COMMAND, asked, proof + bytes(90), b"no")
    with pytest.raises(Unproven):  # a batch is no reply
        read_reply(KEY, TELEMETRY, asked, prover.batch(TELEMETRY, b"rows"), b"rows")


def rows(tick: int, t: float, count: int = 10) -> np.ndarray:
    """Rows that begin with `tick` at the rig's time `t` [s]."""
    found = np.zeros(count, record_dtype(Telemetry))
    found["tick"] = np.arange(tick, tick + count)
    found["t_ns"] = (1e9 * t + 1e6 * np.arange(count)).astype(np.int64)
    return found


def pace() -> Pace:
    """Of a rig whose clock says 1000 s when ours says 50 s, and which sent ticks 0 to 9 since."""
    found = Pace(1e-3, 1_000_000_000_000, 50.0)
    found.judge(rows(0, 1000.0), 50.01)
    return found


@pytest.mark.parametrize(
    ("tick", "t", "now"),
    [
        (10, 1000.01, 50.02),
        (10, 1600.0, 650.0),  # the rig was stopped for 10 minutes: its clock went on, its ticks did not
        (600_000, 1600.0, 650.0),  # this end was stopped, or the link cut: the rig went on
        (1500, 1001.5, 50.02),  # what waited before comes at once
        (10, 1000.01, 650.0),  # this machine's clock went on while the rig's stood still
    ],
)
def test_pauses_of_either_end_are_no_jumps(tick: int, t: float, now: float) -> None:
    found = pace()
    found.judge(rows(tick, t), now)
    found.judge(rows(tick + 10, t + 0.01), now + 0.01)


def test_a_batch_that_we_heard_late_makes_the_next_one_no_forgery() -> None:
    """Our own process stood still for 2.5 s as it came, and what came meanwhile was dropped on the way."""
    found = pace()
    found.judge(rows(10, 1000.01), 52.5)
    found.judge(rows(2450, 1002.45), 52.501)
    with pytest.raises(Unproven, match="t_ns went"):  # and nobody gained time by that
        found.judge(rows(5000, 1005.0), 52.55)


def test_clocks_that_drift_apart_for_a_day_are_followed() -> None:
    found, apart = pace(), 1e-4
    for minute in range(1, 24 * 60):
        now = 50.0 + 60.0 * minute
        rig = 1000.0 + 60.0 * minute * (1.0 - apart)
        found.judge(rows(int(1e3 * (rig - 1000.0)), rig), now)
    with pytest.raises(Unproven, match="t_ns went"):
        found.judge(rows(int(1e3 * (rig - 1000.0)) + 10, rig + SLACK_S + 0.1), now)


@pytest.mark.parametrize(
    ("tick", "t", "now", "text"),
    [
        (60_000, 1000.01, 50.02, r"tick went 60\.0 s ahead in 0\.0 s, more than 2 s too far"),
        (10, 1060.0, 50.02, r"t_ns went 60\.0 s ahead in 0\.0 s"),
        (600_000 + int(1e3 * SLACK_S) + 100, 1600.0, 650.0, "tick went"),
    ],
)
def test_jumps_are_refused_and_change_nothing(tick: int, t: float, now: float, text: str) -> None:
    found = pace()
    with pytest.raises(Unproven, match=text):
        found.judge(rows(tick, t), now)
    found.judge(rows(10, 1000.02), 50.03)


def test_a_batch_out_of_order_is_refused() -> None:
    for field, value in (("tick", 12), ("t_ns", 0)):
        mixed = rows(10, 1000.01)
        mixed[field][5] = value
        with pytest.raises(Unproven, match="not in order, from tick 10 on"):
            pace().judge(mixed, 50.02)
    with pytest.raises(Unproven, match="no rows"):
        pace().judge(rows(0, 0.0, 0), 50.02)
