"""Whatever is asked, lost, stalled, refused or restarted, in any order: a run ends, and its end closes everything."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import get_args

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as some
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from controller.schema.modes import Cause, Mode, Request
from server.http.who import Identity
from server.operate.procedure.override import RETRY_S
from server.operate.procedure.procedure import ORPHANED_TRACKING_S
from server.runs.inbox import ROWS
from server.runs.messages import RunBody
from server.runs.phases import DEADLINES, ENDS, MOVING, Phase
from server.runs.results import KEPT
from server.runs.runs import SILENCE_MAX_S
from tests.server.leave import ANYTHING
from tests.server.run_world import ANN, BOB, LONG, LONGEST_REQUEST, SLACK, World
from tests.server.scripted_rig import Fate

pytestmark = pytest.mark.keyed()


class AnyOrder(RuleBasedStateMachine):
    """Everything that can happen, in any order."""

    def __init__(self) -> None:
        super().__init__()
        self._folder = TemporaryDirectory()
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
                lease.give(BOB, "bob took control over")
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
        self.world.lease.give(ANN, "ann took control over")
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
                assert world.rig.age <= SILENCE_MAX_S + SLACK

    @invariant()
    def nothing_tracks_without_a_run_for_long(self) -> None:
        world = self.world
        machine, since = world.runs._machine, world.tracking_since
        hears = not (world.rig.cut or world.rig.deaf) and world.beating
        if hears and since is not None and (machine is None or not machine.moving):
            for _ in range(3):  # a request of it may be refused or lost as the script says
                world.pass_time(ORPHANED_TRACKING_S + RETRY_S + SLACK)
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
