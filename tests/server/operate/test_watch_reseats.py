"""The log says when the observer was set anew: once each time, and not of one that was there before the page."""

from typing import cast

import numpy as np

from controller.arrays import Rows
from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from server.access.lease import OperatorLease
from server.log.events import EventLog
from server.operate.operator import Operator
from server.operate.watch import Watch
from server.rig.client import Rig
from server.rig.history import History


class Nobody:
    """A rig of which only rows are known, and its operator."""

    trouble, paused, info = "", False, None

    def boot(self) -> int:
        return 7


def row(tick: int, reseats: int) -> Rows:
    rows = np.zeros(1, record_dtype(Telemetry))
    rows["tick"], rows["t_ns"], rows["reseats"] = tick, 10**6 * tick, reseats
    return rows


def test_each_reseat_of_the_observer_is_told_once() -> None:
    nobody, history, events = Nobody(), History(), EventLog()
    watch = Watch(cast(Rig, nobody), history, OperatorLease(), cast(Operator, nobody), events)
    for tick, reseats in enumerate([1, 1, 2, 2, 3, 3], start=1):
        history.add(row(tick, reseats))
        watch.look()
    told = [event for event in events.recent if "observer" in event.text]
    assert [event.level for event in told] == ["warning"] * 2 and "wound" in told[0].text
