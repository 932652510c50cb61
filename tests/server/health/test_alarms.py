"""Alarm limits: one user's own, bounded; the log says once when a figure passes red."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from controller.arrays import Rows
from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from server.health.alarms import AlarmWatch
from server.health.messages import AlarmLimits
from server.health.on_time import OnTime
from server.log.events import EventLog
from server.rig.history import History, Largest
from tests.server.live_server import TestServer

DEFAULTS = AlarmLimits().model_dump()


def test_limits_are_a_users_own_and_are_reset(server: TestServer) -> None:
    one, other = server.page().sign_in(), server.page().sign_in()
    wanted = DEFAULTS | {"residual": {"amber": 1e-3, "red": 2e-3}}
    assert one.get("/api/alarms").json() == DEFAULTS
    assert one.put("/api/alarms", json=wanted).json() == wanted
    assert one.get("/api/alarms").json() == wanted
    assert other.get("/api/alarms").json() == DEFAULTS
    assert one.delete("/api/alarms").json() == DEFAULTS
    assert one.get("/api/alarms").json() == DEFAULTS


@pytest.mark.parametrize(
    ("wrong", "complaint"),
    [
        ({"residual": {"amber": 1e-3, "red": 0.3}}, "less than or equal to 0.2"),
        ({"residual": {"amber": 3e-3, "red": 2e-3}}, "amber = 0.003 is above red = 0.002"),
        ({"on_time": {"amber": 0.9, "red": 0.99}}, "amber = 0.9 is below red = 0.99"),
        ({"residue": {"amber": 1e-3, "red": 2e-3}}, "residue"),
    ],
)
def test_a_limit_out_of_bounds_or_order_is_refused(wrong: dict[str, Any], complaint: str, server: TestServer) -> None:
    page = server.page().sign_in()
    refused = page.put("/api/alarms", json=DEFAULTS | wrong)
    assert (refused.status_code, complaint in refused.text) == (422, True)
    assert page.get("/api/alarms").json() == DEFAULTS


def alarm_watch(
    row: dict[str, Any],
    lateness: Callable[[], float],
    events: EventLog,
    now: Callable[[], float],
    on_time: OnTime | None = None,
) -> AlarmWatch:
    of_loop = lateness, lambda: math.nan, on_time or OnTime()
    return AlarmWatch(lambda: row, lambda: row["server_age"], *of_loop, AlarmLimits, events, now)


def ticked(slot: int, lost: int) -> Rows:
    """A row of a loop of 1 kHz."""
    rows = np.zeros(1, record_dtype(Telemetry))
    rows["t_ns"], rows["slot"], rows["lost"] = slot * 1_000_000, slot, lost
    return rows


def test_each_crossing_of_red_counts_up_one_line_and_what_swings_about_it_does_not() -> None:
    events, now, late, said = EventLog(), [0.0], [0.0], []
    events.listen(said.append)
    row = {"server_age": 0.05, "residual": math.nan, "slot": 0, "lost": 0}
    watch = alarm_watch(row, lambda: late[0], events, lambda: now[0])
    for late[0] in [0.1e-3] + [2e-3, 0.9e-3] * 6 + [0.1e-3] * 3 + [2e-3] * 3:
        now[0] += 1.0
        row["slot"] += 1000
        watch.judge()
    text = "lateness p99 2 ms is above the limit of 1 ms"
    assert [(event.text, event.count) for event in said] == [(text, 1), (text, 2)], "each is told, and recorded"
    assert [(event.text, event.count) for event in events.recent] == [(text, 2)]


def test_lost_ticks_of_the_last_minute_turn_red_by_number_and_by_share() -> None:
    events, now = EventLog(), [0.0]
    row = {"server_age": 0.05, "residual": 1e-3}
    on_time = OnTime()
    watch = alarm_watch(row, lambda: math.nan, events, lambda: now[0], on_time)
    for slot in range(0, 30_000, 1000):
        on_time.add(ticked(slot, 0))
        now[0] += 1.0
        watch.judge()
    on_time.add(ticked(30_000, 700))
    watch.judge()
    assert [event.text for event in events.recent] == [
        "lost ticks 700 is above the limit of 600",
        "on-time share 97.67 % is below the limit of 99 %",
    ]


def test_there_is_no_figure_before_five_seconds_and_a_slow_start_is_none_of_it() -> None:
    on_time = OnTime()
    for slot, lost in ((900, 700), (1000, 700), (5800, 700)):
        on_time.add(ticked(slot, lost))
        assert math.isnan(on_time.share) and math.isnan(on_time.lost)
    on_time.add(ticked(5900, 710))
    assert (on_time.share, on_time.lost) == (pytest.approx(0.998), 10)


@pytest.mark.parametrize(("slot", "lost"), [(100, 3), (200_000, 3)], ids=["an earlier slot", "fewer lost, later"])
def test_another_start_of_the_rig_is_counted_by_itself_and_never_beyond_all(slot: int, lost: int) -> None:
    on_time = OnTime()
    for seen in range(0, 100_000, 500):
        on_time.add(ticked(seen, seen // 2))
    assert on_time.share == 0.5
    on_time.add(ticked(slot, lost))
    assert math.isnan(on_time.share)
    for seen in range(500, 10_000, 500):
        on_time.add(ticked(slot + seen, lost))
    assert on_time.share == 1.0


def test_what_was_lost_more_than_a_minute_ago_is_forgotten() -> None:
    on_time = OnTime()
    for seen in range(0, 80_000, 16):
        on_time.add(ticked(seen, min(seen // 2, 1000)))
    assert (on_time.share, on_time.lost) == (1.0, 0.0)


def test_the_age_of_a_command_is_the_largest_of_all_rows_since_it_was_judged_last() -> None:
    history = History()
    age = Largest(history, "server_age").take
    assert math.isnan(age())
    for ages in ([0.01, 0.4, 0.02], [0.03, 0.02]):
        rows = np.zeros(len(ages), record_dtype(Telemetry))
        rows["server_age"] = ages
        history.add(rows)
    assert age() == pytest.approx(0.4)
    assert math.isnan(age()), "no row came since"
    history.add(rows)
    assert age() == pytest.approx(0.03)
