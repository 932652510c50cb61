"""Every phase of a run, and what ends it there: its end closes everything."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from controller.schema.modes import Cause, Mode, Request
from controller.text.markdown import filled
from server.operate.procedure.override import RETRY_S
from server.operate.procedure.procedure import ORPHANED_TRACKING_S
from server.runs.inbox import ROWS
from server.runs.messages import RunBody
from server.runs.phases import CLOSES, DEADLINES, ENDS, MOVING, PAGE, TRANSITIONS, Closes, Event, Phase, markdown
from tests.server.leave import ANYTHING
from tests.server.run_world import BOB, LONGEST_REQUEST, World

pytestmark = pytest.mark.keyed()


def test_the_table_is_whole() -> None:
    assert set(TRANSITIONS) == set(Phase)
    for phase, events in TRANSITIONS.items():
        assert bool(events) == (phase not in ENDS)
        assert not events or set(events) >= {Event.STOP, Event.LEASE_LOST, Event.RIG_LOST, Event.LATE, Event.CLOSED}
        assert not events or all(Event.CLOSED in events and events[Event.CLOSED] in ENDS for _ in events)
    assert set(CLOSES) == set(ENDS) and all(Closes.RECORDING in closes for closes in CLOSES.values())
    unbounded = set(Phase) - set(DEADLINES) - set(ENDS)
    assert unbounded == {Phase.APPROACH, Phase.RUNNING} and unbounded < set(MOVING)


def test_the_document_shows_the_table() -> None:
    text = PAGE.read_text()
    assert filled(text, "phases", markdown()) == text


@pytest.fixture
def world(tmp_path: Path) -> Any:
    found = World(tmp_path)
    yield found
    found.close()


def begin(world: World, laps: int | None = None) -> None:
    world.ask("start", RunBody(reference="circle_1hz", laps=laps))
    world.pass_time(0.3)
    assert world.phase == Phase.APPROACH


def closed(world: World, results: int) -> bool:
    kept, inbox = len(world.results.all()), world.runs.inbox
    return (kept, inbox.is_open, len(inbox), world.recordings.going) == (results, False, 0, 0.0)


def test_stop_ends_a_paused_run(world: World) -> None:
    begin(world)
    world.ask("pause")
    world.pass_time(0.3)
    assert world.phase == Phase.PAUSED
    stopped = world.ask("stop")
    world.pass_time(60.0)
    assert stopped.result().state == "stopped" and closed(world, 1)


def test_a_refused_start_leaves_nothing_open(world: World) -> None:
    for _ in range(2):
        world.rig.next[Request.TRACK] = "refused"
        asked = world.ask("start", RunBody(reference="circle_1hz"))
        world.pass_time(60.0)
        assert "no operator is present" in str(asked.result()) and closed(world, 0)
    assert world.runs.state() is None


def test_a_track_that_a_stall_turned_into_hold_within_its_tick_ends_the_run(world: World) -> None:
    world.rig.next[Request.TRACK] = "stalled"
    asked = world.ask("start", RunBody(reference="circle_1hz"))
    world.pass_time(0.3)
    assert (asked.result().state, asked.result().reason) == ("broken off", "HOLD (loop stalled)")
    assert closed(world, 1)
    begin(world)


def test_a_track_whose_answer_is_lost_has_its_run(world: World) -> None:
    world.rig.next[Request.TRACK] = "taken, its answer lost"
    asked = world.ask("start", RunBody(reference="circle_1hz"))
    world.pass_time(0.3)
    assert not world.rig.next and asked.result().state == "approach"
    assert world.phase == Phase.APPROACH


def test_nobody_reads_for_a_minute_and_the_run_ends_with_its_reason(world: World) -> None:
    begin(world)
    world.beating = False
    world.pass_time(60.0)
    assert len(world.runs.inbox) <= ROWS
    world.beating = True
    world.pass_time(1.0)
    last = world.runs.last()
    assert last is not None and last.reason == "its rows were not read for 30 s"
    assert closed(world, 1) and world.rig.mode == Mode.HOLD


def test_a_run_that_stays_paused_ends_by_itself(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(DEADLINES, Phase.PAUSED, 60.0)  # an hour takes a minute of processor time
    begin(world)
    world.ask("pause")
    world.pass_time(DEADLINES[Phase.PAUSED] + 2.0)
    last = world.runs.last()
    assert last is not None and (last.state, last.reason) == ("stopped", "it was paused for 60 s")
    assert closed(world, 1)


def test_a_rig_that_tracks_without_a_run_is_held(world: World) -> None:
    world.rig.planned, world.rig.ticks = True, 10**9
    world.rig.request(Request.TRACK, ANYTHING)
    world.pass_time(ORPHANED_TRACKING_S + RETRY_S)
    assert world.rig.mode == Mode.HOLD
    assert [event.text for event in world.events.recent] == ["the rig tracks though no run is under way: hold"]


UNENDED = [phase for phase in Phase if phase not in ENDS]
SLOW_DISK = {Phase.PREPARING: 3.0}


def reach(world: World, phase: Phase, then: Callable[[], None]) -> None:
    """Lead a run to `phase`, do `then` there, and let a minute and more pass."""
    world.recordings.seconds = SLOW_DISK.get(phase, 0.0)
    reached = world.loop.create_future()

    def watch() -> None:
        if world.phase == phase and not reached.done():
            reached.set_result(None)
            then()

    world.loop.before_jump = watch
    world.ask("start", RunBody(reference="circle_1hz", laps=None))
    world.pass_time(3.0)
    if phase in (Phase.PAUSING, Phase.PAUSED, Phase.RETURNING, Phase.RESUMING):
        world.ask("pause")
        world.pass_time(0.3)
    if phase in (Phase.RETURNING, Phase.RESUMING):
        world.ask("resume")
    elif phase == Phase.STOPPING:
        world.ask("stop")
    elif phase == Phase.BREAKING:
        world.lease.give(BOB, "bob took control over")
    world.pass_time_until_ended(LONGEST_REQUEST + 1.0)
    assert reached.done() and all(task.done() for _, task in world.asked)


@pytest.mark.parametrize("phase", UNENDED)
def test_a_server_may_end_in_any_phase(world: World, phase: Phase) -> None:
    reach(world, phase, world.runs.close)
    assert world.phase == (Phase.REFUSED if phase == Phase.PREPARING else Phase.BROKEN)
    assert [one.reason for one in world.results.all()] == ["the server ended"] * (phase != Phase.PREPARING)
    assert not world.runs.inbox.is_open


def cut_off(world: World) -> None:
    world.rig.cut = True


def deafen(world: World) -> None:
    world.rig.deaf = True


def part(world: World) -> None:
    world.rig.cut = world.rig.deaf = True


def lose_lease(world: World) -> None:
    world.lease.give(BOB, "bob took control over")


def stop_beating(world: World) -> None:
    world.beating = False
    world.loop.call_later(50.0, setattr, world, "beating", True)


BREAKDOWNS: dict[str, Callable[[World], object]] = {
    "no row comes": cut_off,
    "the link is cut": part,
    "the rig restarts": lambda world: world.rig.restart(),
    "FAULT": lambda world: world.rig.move(Mode.FAULT, Cause.TRACKING_ERROR),
    "E-STOP": lambda world: world.rig.request(Request.E_STOP, ANYTHING),
    "another has control": lose_lease,
    "stop": lambda world: world.ask("stop"),
    "REST": lambda world: world.rig.request(Request.REST, ANYTHING),
}


@pytest.mark.parametrize("what", BREAKDOWNS)
@pytest.mark.parametrize("phase", UNENDED)
def test_whatever_breaks_in_any_phase_ends_the_run(world: World, phase: Phase, what: str) -> None:
    reach(world, phase, lambda: BREAKDOWNS[what](world))
    assert world.phase in ENDS
    assert closed(world, results=int(world.phase != Phase.REFUSED))


@pytest.mark.parametrize("phase", [Phase.STARTING, Phase.RESUMING])
def test_who_loses_control_before_a_row_tells_of_the_run_is_refused(world: World, phase: Phase) -> None:
    reach(world, phase, lambda: lose_lease(world))
    assert "no longer operates" in str(world.asked[-1][1].result())


@pytest.mark.parametrize("phase", UNENDED)
def test_a_rig_that_hears_nothing_ends_nothing_but_what_waits_for_it(world: World, phase: Phase) -> None:
    """Its rows come, so a run in motion is followed on; it holds by itself as soon as presence ends."""
    reach(world, phase, lambda: deafen(world))
    waits = phase not in (Phase.APPROACH, Phase.RUNNING, Phase.PAUSED, Phase.RETURNING)
    assert (world.phase in ENDS) == waits or phase in (Phase.STARTING, Phase.RESUMING)
    world.rig.deaf = False
    world.lease.give(BOB, "bob took control over")
    world.pass_time(5.0)
    assert world.phase in ENDS and world.rig.mode == Mode.HOLD


@pytest.mark.parametrize("phase", UNENDED)
def test_a_server_that_stands_still_for_a_minute_does_not_fill_its_memory(world: World, phase: Phase) -> None:
    reach(world, phase, lambda: stop_beating(world))
    assert len(world.runs.inbox) <= ROWS
    world.lease.give(BOB, "bob took control over")
    world.pass_time(5.0)
    assert world.phase in ENDS and closed(world, results=int(world.phase != Phase.REFUSED))
