"""Whatever is asked, lost, stalled, refused or restarted, in any order: a run ends, and its end closes everything.

The real `Runs`, `Tracker`, `Inbox` and lease, on a scripted rig and a clock that jumps.
"""

import asyncio
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, cast, get_args

import numpy as np
import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as some
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from controller.errors import TendrilError
from controller.reference.feasible.within_reach import projected
from controller.reference.library import static_map
from controller.schema.modes import Cause, Mode, Request
from controller.schema.parameters import RigParameters, Settings
from server.auth import Identity
from server.automatic import Automatic
from server.events import EventLog
from server.lease import OperatorLease
from server.operator import Operator
from server.rig import Rig
from server.runs import runs as module
from server.runs.inbox import ROWS
from server.runs.laps import Lap, allowed_by
from server.runs.messages import RunBody
from server.runs.phases import CLOSES, DEADLINES, ENDS, MOVING, PAGE, TRANSITIONS, Closes, Event, Phase, filled
from server.runs.results import KEPT, Results
from server.runs.runs import AGAIN, GONE, STRAY, Runs
from server.runs.tracker import Tracker
from tests.server.leave import ANYTHING, permits_of
from tests.server.scripted_rig import Fate, ScriptedRig
from tests.server.virtual_time import Inline, VirtualLoop

ANN, BOB = Identity("a", "ann"), Identity("b", "bob")
PATH = np.column_stack([np.full(3000, 0.248), 0.025 - 0.005 * np.cos(2.0 * np.pi * np.arange(3000) / 3000)])
LONG = bool(os.environ.get("TENDRIL_LONG"))
SLACK = 0.5
"""Beats, polls and the answer that is under way [s]."""
LONGEST_REQUEST = sum(DEADLINES[phase] for phase in (Phase.PREPARING, Phase.STARTING)) + SLACK


def planned(body: RunBody, rig: RigParameters, settings: Settings) -> Lap:
    """Instead of planning: a line of 3 s, there and back."""
    allowed = allowed_by(rig, settings, drawn=True)
    return Lap("line", np.empty((0, 2)), PATH, 0, torques(), None, np.zeros(len(PATH), bool), allowed, known=False)


@cache
def torques() -> Any:
    """What holds P1 along the line (n, 2) [N m]."""
    rig = RigParameters()
    return projected(static_map(rig.actuator, rig.controller), PATH).u


class Recordings:
    """Instead of the recorder: counts."""

    def __init__(self) -> None:
        self.going = self.seconds = 0.0
        self.id = 0

    async def begin_run(self, *_: str) -> None:
        await asyncio.sleep(self.seconds)
        self.going, self.id = 1.0, self.id + 1

    def end_run(self) -> None:
        self.going = 0.0

    def recording(self) -> str | None:
        return str(self.id) if self.going else None

    def approach(self, first: int, end: int) -> None:
        assert end > first


class World:
    """Runs on a scripted rig, a beat, and people's requests, each a task."""

    def __init__(self, folder: Path) -> None:
        self.loop = VirtualLoop()
        self.lease, self.events, self.recordings = OperatorLease(self.loop.time), EventLog(), Recordings()
        self.rig = ScriptedRig(lambda rows: self.runs.inbox.put(rows), self.loop.time)
        tracker = Tracker(cast(Rig, self.rig), cast(Operator, self.rig))
        tracker._threads = Inline()
        automatic, self.results = cast(Automatic, self.recordings), Results(folder / "runs.json")
        self.runs = Runs(tracker, automatic, self.events, self.results, self.loop.time)
        self.asked: list[tuple[float, asyncio.Task[Any]]] = []
        self.begun = 0
        self.beating = True
        self.tracking_since: float | None = None
        self.lease.acquire(ANN)
        self.permits = permits_of(self.lease)
        self._tasks = [self.loop.create_task(self.rig.run()), self.loop.create_task(self._beat())]
        self.pass_time(0.1)

    @property
    def phase(self) -> Phase | None:
        return self.runs._machine.phase if self.runs._machine else None

    def pass_time(self, seconds: float) -> None:
        self.loop.run_until_complete(asyncio.sleep(seconds))

    def ask(self, verb: str, *body: RunBody, who: Identity = ANN) -> asyncio.Task[Any]:
        task = self.loop.create_task(self._asked(verb, *body, who=who))
        self.asked.append((self.loop.time(), task))
        return task

    async def _asked(self, verb: str, *body: RunBody, who: Identity) -> Any:
        try:
            return await getattr(self.runs, verb)(*body, self.permits.operator(who))
        except TendrilError as error:
            return error

    def close(self) -> None:
        for task in [*self._tasks, *(task for _, task in self.asked)]:
            task.cancel()
        self.pass_time(0.1)
        self.loop.close()

    async def _beat(self) -> None:
        while True:
            await asyncio.sleep(1 / 60)
            holder = self.lease.holder
            if holder is not None:
                self.lease.touch(holder)
                self.permits.operator(holder).sign()
            if self.beating:
                self.runs.look()
            tracks = self.rig.mode == Mode.TRACK
            self.tracking_since = (self.tracking_since or self.loop.time()) if tracks else None


class AnyOrder(RuleBasedStateMachine):
    """Everything that can happen, in any order."""

    def __init__(self) -> None:
        super().__init__()
        self._folder = TemporaryDirectory()
        self._plan, module._plan = module._plan, planned
        self.world = World(Path(self._folder.name))
        self.ended: set[int] = set()

    @rule(laps=some.sampled_from([1, None]), seconds=some.sampled_from([0.0, 0.02, 0.3, 3.0, 6.0]))
    def run(self, laps: int | None, seconds: float) -> None:
        """As it should be, so far."""
        self.mend()
        self.start(laps, True, ANN, seconds)

    @rule(
        laps=some.sampled_from([1, None]),
        record=some.booleans(),
        who=some.sampled_from([ANN, BOB]),
        seconds=some.sampled_from([0.0, 0.3]),
    )
    def start(self, laps: int | None, record: bool, who: Identity, seconds: float) -> None:
        self.world.ask("start", RunBody(reference="circle_1hz", laps=laps, record=record), who=who)
        self.world.pass_time(seconds)

    @rule(verb=some.sampled_from(["pause", "resume", "stop"]), seconds=some.sampled_from([0.0, 0.01, 0.3, 3.0]))
    def change(self, verb: str, seconds: float) -> None:
        self.world.ask(verb)
        self.world.pass_time(seconds)

    @precondition(lambda self: self.world.phase in MOVING)
    @rule(ways=some.sampled_from([("pause",), ("pause", "resume"), ("stop",)]), seconds=some.sampled_from([0.02, 0.3]))
    def change_what_moves(self, ways: tuple[str, ...], seconds: float) -> None:
        for verb in ways:
            self.change(verb, seconds)

    @rule(seconds=some.sampled_from([0.02, 0.1, 1.0, 3.0, 7.0]))
    def wait(self, seconds: float) -> None:
        self.world.pass_time(seconds)

    @rule(request=some.sampled_from([Request.TRACK, Request.HOLD]), fate=some.sampled_from(get_args(Fate)))
    def go_wrong(self, request: Request, fate: Fate) -> None:
        self.world.rig.next[request] = fate

    @rule(request=some.sampled_from([Request.HOLD, Request.FOLLOW, Request.REST, Request.E_STOP]))
    def somebody_asks(self, request: Request) -> None:
        self.world.rig.request(request, ANYTHING).add_done_callback(lambda done: done.exception())

    @rule(what=some.sampled_from(["cut", "deaf", "fault", "restart", "hold", "lease", "disk", "beat", "end"]))
    def break_down(self, what: str) -> None:
        rig, lease = self.world.rig, self.world.lease
        match what:
            case "cut":
                rig.cut = True  # no row and no answer comes
            case "deaf":
                rig.deaf = True  # what is asked does not arrive
            case "fault" if rig.mode in (Mode.HOLD, Mode.TRACK, Mode.FOLLOW):
                rig.move(Mode.FAULT, Cause.TRACKING_ERROR)
            case "restart":
                rig.restart()
            case "hold" if rig.mode == Mode.TRACK:
                rig.move(Mode.HOLD, Cause.OPERATOR_LOST)
            case "lease":
                lease.give(BOB)
            case "disk":
                self.world.recordings.seconds = 3.0 - self.world.recordings.seconds
            case "beat":
                self.world.beating = False
            case "end" if self.world.phase is not None:
                self.world.runs.close()
                assert self.world.phase in ENDS

    @rule()
    def mend(self) -> None:
        rig = self.world.rig
        rig.cut = rig.deaf = False
        self.world.beating = True
        if self.world.phase not in MOVING:
            rig.move(Mode.HOLD, Cause.OPERATOR)
        self.world.lease.give(ANN)
        self.world.pass_time(0.1)

    @invariant()
    def an_end_closed_everything(self) -> None:
        world, machine = self.world, self.world.runs._machine
        if machine is None or machine.ended:
            assert not world.runs.inbox.is_open and not len(world.runs.inbox)
        if machine is None or not machine.ended or id(machine) in self.ended:
            return
        self.ended.add(id(machine))
        self.kept = machine  # its id is not used again
        assert machine.phase == Phase.REFUSED or machine.reason or machine.phase == Phase.DONE
        newest = world.runs.last()
        if machine.phase != Phase.REFUSED:
            assert newest is not None and newest.state == machine.shown and newest.reason == machine.reason
        if machine.reason != "the server ended":
            assert not world.recordings.going

    @invariant()
    def every_queue_has_its_bound(self) -> None:
        assert len(self.world.runs.inbox) <= ROWS
        assert len(self.world.results.all()) <= KEPT

    @invariant()
    def every_wait_has_an_end(self) -> None:
        world, machine = self.world, self.world.runs._machine
        now = world.loop.time()
        for since, task in world.asked:
            assert task.done() or now - since < LONGEST_REQUEST, f"asked {now - since:.1f} s ago"
        if machine is not None and not machine.ended and world.beating:
            bound = DEADLINES.get(machine.phase, float("inf"))
            assert now - machine.since <= bound + 1.0 or machine.late()
            world.pass_time(0.05)
            if not machine.ended:
                assert world.rig.age <= GONE + SLACK

    @invariant()
    def nothing_tracks_without_a_run_for_long(self) -> None:
        world = self.world
        machine, since = world.runs._machine, world.tracking_since
        hears = not (world.rig.cut or world.rig.deaf) and world.beating
        if hears and since is not None and (machine is None or not machine.moving):
            for _ in range(3):  # a request of it may be refused or lost as the script says
                world.pass_time(STRAY + AGAIN + SLACK)
            machine = world.runs._machine
            assert world.rig.mode != Mode.TRACK or (machine is not None and machine.moving)

    def teardown(self) -> None:
        world = self.world
        try:
            world.beating = True
            world.rig.cut = world.rig.deaf = False
            world.rig.next.clear()
            if holder := world.lease.holder:
                world.lease.release(holder)
            for _ in range(round(LONGEST_REQUEST)):
                machine = world.runs._machine
                if (machine is None or machine.ended) and all(task.done() for _, task in world.asked):
                    break
                world.pass_time(1.0)
            world.pass_time(1.0)
            machine = world.runs._machine
            assert machine is None or machine.ended
            assert all(task.done() for _, task in world.asked)
            assert world.rig.mode != Mode.TRACK
            self.an_end_closed_everything()
        finally:
            module._plan = self._plan
            world.close()
            self._folder.cleanup()


TestAnyOrder = AnyOrder.TestCase
TestAnyOrder.settings = settings(
    max_examples=3000 if LONG else 30,
    stateful_step_count=30,
    deadline=None,
    suppress_health_check=list(HealthCheck),
    derandomize=not LONG,
)


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
    assert filled(text) == text


@pytest.fixture
def world(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.setattr(module, "_plan", planned)
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
    world.pass_time(STRAY + AGAIN)
    assert world.rig.mode == Mode.HOLD
    assert [event.text for event in world.events.recent] == ["the rig tracks though no run is under way: hold"]


UNENDED = [phase for phase in Phase if phase not in ENDS]
SLOW_DISK = {Phase.PREPARING: 3.0}


def reach(world: World, phase: Phase, then: Callable[[], None]) -> None:
    """Lead a run to `phase`, do `then` there, and let a minute and more pass."""
    world.recordings.seconds = SLOW_DISK.get(phase, 0.0)

    async def watch() -> None:
        while world.phase != phase:
            await asyncio.sleep(1e-3)
        then()

    reached = world.loop.create_task(watch())
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
        world.lease.give(BOB)
    world.pass_time(LONGEST_REQUEST)
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
    world.lease.give(BOB)


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
    world.lease.give(BOB)
    world.pass_time(5.0)
    assert world.phase in ENDS and world.rig.mode == Mode.HOLD


@pytest.mark.parametrize("phase", UNENDED)
def test_a_server_that_stands_still_for_a_minute_does_not_fill_its_memory(world: World, phase: Phase) -> None:
    reach(world, phase, lambda: stop_beating(world))
    assert len(world.runs.inbox) <= ROWS
    world.lease.give(BOB)
    world.pass_time(5.0)
    assert world.phase in ENDS and closed(world, results=int(world.phase != Phase.REFUSED))
