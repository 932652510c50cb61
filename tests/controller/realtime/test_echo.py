"""How long a command waits until the loop has looked at it: on a clock of the test's own, with a loop that pauses."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from controller.realtime import command_handler
from controller.realtime.mailbox import mailbox, words
from controller.realtime.ring import create_ring, ring_push
from controller.schema.layout import record_dtype, to_record
from controller.schema.messages import Command, RigInfo, Telemetry
from controller.schema.modes import Cause, Mode
from controller.schema.parameters import RigParameters, SafetyLimits

pytestmark = pytest.mark.alone

PAUSE_NS = 200_000_000


@pytest.mark.parametrize("allowed", [0.05, 0.3])
def test_a_loop_is_waited_for_as_long_as_its_limits_let_it_pause(
    allowed: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ring, row, now = create_ring("test", 1, tmp_path, capacity=8), np.zeros(1, record_dtype(Telemetry)), 0

    def sleep(seconds: float) -> None:
        nonlocal now
        now += int(seconds * 1e9)
        row["t_ns"], row["mode"] = now, Mode.HOLD
        if now > PAUSE_NS:
            ring_push(ring.header, ring.rows, words(row))

    monkeypatch.setattr(command_handler, "time", SimpleNamespace(monotonic_ns=lambda: now, sleep=sleep))
    parameters = RigParameters(limits=SafetyLimits(loop_gap=allowed))
    info = RigInfo.model_construct(boot=1, parameters=parameters)
    box = mailbox(to_record(Command()).dtype)
    handler = command_handler.CommandHandler(info, ring, box, *cast(Any, (None, None, None)))
    reply = handler.submit(Command(boot=1, n=3))
    assert box[0] == 2, "the loop finds it when it goes on"
    assert (reply.accepted, reply.mode) == ((True, Mode.HOLD) if allowed > 0.2 else (False, Mode.VENTED))
    assert (reply.cause == Cause.LOOP_STALLED) == (allowed < 0.2)
