"""What the server does by itself when the rig or the lease changes."""

from typing import cast

import numpy as np
import pytest

from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.schema.modes import Mode, Request
from server.access.lease import OperatorLease
from server.http.who import Identity
from server.log.events import EventLog
from server.operate.operator import Operator
from server.operate.watch import Watch
from server.rig.client import Rig
from server.rig.history import History

ANN, BOB = Identity("a", "ann"), Identity("b", "bob")


class Asked:
    """Rig and operator in one: connected, and keeps what was asked for."""

    trouble, paused, info = "", False, None

    def __init__(self) -> None:
        self.requests: list[Request] = []

    def boot(self) -> int:
        return 7

    def hold_left(self) -> None:
        self.requests.append(Request.HOLD)


@pytest.mark.parametrize("mode", Mode)
@pytest.mark.parametrize("handed_on", [False, True])
def test_a_new_operator_inherits_no_motion(mode: Mode, handed_on: bool) -> None:
    """In HOLD too: a FOLLOW of the old operator may be on its way. A rig that rests or is stopped is left alone."""
    asked, lease, history = Asked(), OperatorLease(), History()
    watch = Watch(cast(Rig, asked), history, lease, cast(Operator, asked), EventLog())
    row = np.zeros(1, record_dtype(Telemetry))
    row["mode"] = mode
    history.add(row)
    assert lease.acquire(ANN)
    watch.look()
    assert asked.requests == []
    lease.release(ANN)
    if handed_on:
        assert lease.acquire(BOB)
    watch.look()
    watch.look()
    assert asked.requests == [Request.HOLD] * (mode in (Mode.HOLD, Mode.FOLLOW, Mode.TRACK))


def test_a_rig_that_takes_no_command_is_told_once_and_when_it_takes_them_again() -> None:
    asked, events = Asked(), EventLog()
    watch = Watch(cast(Rig, asked), History(), OperatorLease(), cast(Operator, asked), events)
    watch.look()
    for asked.trouble in ("another server", "another server", "", ""):
        watch.look()
    told = [(event.level, event.text) for event in events.recent if "from this server" in event.text]
    assert told[0] == ("error", "the rig takes no command from this server: another server")
    assert [level for level, _ in told] == ["error", "info"]
