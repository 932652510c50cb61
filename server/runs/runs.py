"""The run under way: from what an operator asks for, over the rig's TRACK, to the result that is kept.

Requests, replies, rows and time are events of one state machine (`phases.py`): every look reads the rows and judges
the time, during every wait, and a request goes on only while the run is in the phase that it waits in.
"""

import asyncio
import contextlib
import time
from collections.abc import Callable, Coroutine, Iterator
from datetime import UTC, datetime
from typing import Annotated, Any, TypeVar

from controller.errors import CommandRefused, NotAllowed, RigUnreachable, TendrilError
from controller.schema.messages import RigInfo
from controller.schema.modes import Request
from recordings.format.annotations import Approach
from recordings.format.messages import Level
from server.access.permit import Permit, own
from server.http.given import given
from server.operate.procedure.motion import ROW_POLL_S
from server.operate.procedure.procedure import GONE, RESTARTED, Procedure, Procedures
from server.recorder.automatic import Automatic
from server.runs.inbox import Inbox
from server.runs.lap import Leg, Order, in_slot, velocity_gain
from server.runs.learning.plans import Plans
from server.runs.messages import RunBody, RunResult, RunState
from server.runs.phases import ASKED, CLOSES, HALTING, MOVING, Closes, Event, Machine, Phase, too_long, where
from server.runs.results import Results
from server.runs.run import About, Before, Run
from server.runs.tracker import Tracker

SILENCE_MAX_S = 5.0
"""A rig that is silent for longer ends its run."""
UPDATES_HZ = 8
"""How often pages are told of a run in motion."""

T = TypeVar("T")


class _Following(Procedure):
    """The run under way, for the engine. Its rows tell what else is asked for, so it hears nothing."""

    silence_max_s = SILENCE_MAX_S

    def __init__(self, runs: "Runs", machine: Machine, starter: Permit) -> None:
        super().__init__(runs.context, "run", starter)
        self._runs, self._machine = runs, machine

    @property
    def tracks(self) -> bool:
        return self._machine.moving

    def hear(self, request: Request, permit: Permit | None) -> None:
        pass

    def look(self) -> None:
        self._runs.look()

    def close(self) -> None:
        self._runs.close()


class Runs:
    """At most one run at a time. Only the event loop uses it, but for `inbox`, which the link fills."""

    def __init__(
        self,
        procedures: Procedures,
        tracker: Tracker,
        plans: Plans,
        automatic: Automatic,
        results: Results,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.inbox = Inbox()
        self._tracker, self._plans, self._automatic = tracker, plans, automatic
        self.context, self._procedures, self._events = procedures.context, procedures, procedures.context.events
        self._results, self._clock = results, clock
        self._machine: Machine | None = None
        self._run: Run | None = None
        self._body: RunBody | None = None
        """What was followed last."""
        self._earlier: Run | None = None
        """What is shown again if the run is refused."""
        self._following: _Following | None = None

    async def start(self, body: RunBody, permit: Permit) -> RunState:
        """Plan, approach from where the rig's reference is, and follow; returns once a row shows that it began.

        Raises CommandRefused where the rig cannot or a run is under way, UnknownReference, and ParameterError for a
        drawing or reference that cannot be followed.
        """
        self._require_free()
        info = self._tracker.require_ready()
        machine = self._machine = Machine(self._clock)
        self._following, self._earlier = _Following(self, machine, permit), self._run
        self._procedures.add(self._following)
        with self._refusing(machine):
            leg, before, about = await self._prepare(machine, body, info)
            run = self._run = Run(about, leg, machine, before, self._automatic.recording())
            await self._track(machine)
            self._body = body if body.learning != "anew" else body.model_copy(update={"learning": "on"})
        return _kept(run)

    async def again(self, permit: Permit) -> RunState:
        """Follow what was followed last; raises CommandRefused where nothing was yet, and what `start` does."""
        if self._body is None:
            raise CommandRefused("no run has begun since the server started; choose what to follow, and run it")
        return await self.start(self._body, permit)

    async def pause(self, permit: Permit) -> RunState:
        """Hold, and remember where; raises CommandRefused when no run is in motion."""
        run = self._require_run()
        if not self._meet(Event.PAUSE, f"by {permit.name}"):
            raise CommandRefused(f"run {run.about.id} is {run.machine.phase.value}")
        await self._halt(run, permit)
        return run.state()

    async def resume(self, permit: Permit) -> RunState:
        """Go on where it was paused; raises CommandRefused when no run is paused, or the rig cannot."""
        run = self._require_run()
        if not self._meet(Event.RESUME, run.machine.reason):
            raise CommandRefused(f"run {run.about.id} is not paused")
        self._procedure.starter = permit
        with self._refusing(run.machine):
            await self._return(run)
            await self._track(run.machine)
        return _kept(run)

    async def stop(self, permit: Permit) -> RunState:
        """Hold, and end the run during any wait; raises CommandRefused when there is none."""
        permit.require(Request.HOLD)
        if self._machine is not None and self._machine.phase == Phase.PREPARING:
            self._meet(Event.STOP, f"stopped by {permit.name} before it began")
            raise CommandRefused("the run was still being prepared; it does not begin")
        run = self._require_run()
        if not self._meet(Event.STOP, f"by {permit.name}"):
            raise CommandRefused(f"run {run.about.id} is {run.machine.phase.value}")
        if run.machine.ended:
            await self._tracker.halt(own())
        else:
            await self._halt(run, own())  # though the lease may be lost meanwhile
        return run.state()

    def state(self) -> RunState | None:
        """The run under way, or how the last one ended; None before the first."""
        return self._run.state() if self._run else None

    def results(self) -> list[RunResult]:
        """What came of the last runs, newest first."""
        return self._results.all()

    def last(self) -> RunResult | None:
        """What came of the last one; None before the first."""
        return self._results.newest

    def key(self) -> object:
        """Differs whenever pages should be told at once."""
        if self._run is None:
            return None
        state = self._run.state()
        return state.id, state.state, state.reason, int(state.elapsed * UPDATES_HZ)

    def look(self) -> None:
        """A job: read the rig's rows, then judge lease and time."""
        machine = self._machine
        if machine is not None and not machine.ended:
            self._read(machine)
            self._judge(machine)

    def close(self) -> None:
        """The server ends, and the rig will hold: keep what came of the run so far. The recorder ends by itself."""
        machine, run = self._machine, self._run
        if machine is None or not machine.meet(Event.CLOSED, "the server ended"):
            return
        self._over()
        if run is not None and machine.phase == Phase.BROKEN:
            with contextlib.suppress(OSError):
                self._results.add(run.result())

    async def _prepare(self, machine: Machine, body: RunBody, info: RigInfo) -> tuple[Leg, Before, About]:
        """Everything before the rig is asked to track."""
        rig, settings = info.parameters, self._tracker.settings
        lap = await self._while(machine, self._plans.lap(body, rig, settings))
        held = await self._while(machine, self._tracker.hold(self._procedure.starter))
        order = Order(lap, body.laps, rig, settings, body.learning)
        leg = await self._while(machine, self._plans.leg(order, held.u))
        if body.record:
            await self._while(machine, self._automatic.begin_run(lap.name, self._procedure.starter.name))
        await self._while(machine, self._tracker.upload(leg, self._procedure.starter))
        name, own = in_slot(info, settings)
        K_FF = velocity_gain(lap.kind, rig, settings, own)
        return leg, held.before, About(self._results.next_id(), order, datetime.now(UTC), K_FF, name)

    async def _return(self, run: Run) -> None:
        """Everything before the rig is asked to track again."""
        rig = self._tracker.require_ready().parameters
        held = await self._while(run.machine, self._tracker.hold(self._procedure.starter))
        order = run.about.order._replace(rig=rig, settings=self._tracker.settings)
        leg = await self._while(run.machine, self._plans.leg(order, held.u, run.left))
        await self._while(run.machine, self._tracker.upload(leg, self._procedure.starter))
        run.begin(leg, held.before)

    async def _track(self, machine: Machine) -> None:
        """Ask the rig to track, and wait until its rows tell. Where its answer is lost they tell all the same."""
        if not self.inbox.is_open:
            self.inbox.open()
        self._meet(Event.READY)
        unanswered = await self._answer(machine, ASKED, self._tracker.track(self._procedure.starter))
        await self._rows(machine, ASKED)
        if unanswered and machine.ended:
            raise unanswered

    async def _halt(self, run: Run, permit: Permit) -> None:
        """Let the rig hold, and wait until the rows have said so. Where it cannot, the run goes on."""
        try:
            unanswered = await self._answer(run.machine, HALTING, self._tracker.halt(permit))
        except TendrilError:
            if run.tracked:
                self._meet(Event.UNHELD)
            raise
        await self._rows(run.machine, HALTING)
        if unanswered and run.machine.phase == Phase.BROKEN:
            raise unanswered

    async def _answer(
        self, machine: Machine, within: tuple[Phase, ...], asking: Coroutine[Any, Any, object]
    ) -> RigUnreachable | None:
        """Wait for the rig's answer while the run is `within`; the error where there was none."""
        try:
            await self._while(machine, asking, within)
        except RigUnreachable as error:
            return error
        except _Left:
            pass
        return None

    async def _rows(self, machine: Machine, within: tuple[Phase, ...]) -> None:
        """Wait until rows, or the time, have led the run out of `within`."""
        self.look()
        while self._machine is machine and machine.phase in within:
            await asyncio.sleep(ROW_POLL_S)
            self.look()

    async def _while(
        self, machine: Machine, work: Coroutine[Any, Any, T], within: tuple[Phase, ...] | None = None
    ) -> T:
        """What comes of `work`; CommandRefused as soon as the run has left the phase that it is in."""
        phases, task = within or (machine.phase,), asyncio.ensure_future(work)
        try:
            while not task.done() and machine.phase in phases:
                await asyncio.wait([task], timeout=ROW_POLL_S)
                self.look()
        finally:
            task.cancel()
            task.add_done_callback(lambda done: done.cancelled() or done.exception())
        if machine.phase not in phases:
            raise _Left(where(machine))
        return task.result()

    @contextlib.contextmanager
    def _refusing(self, machine: Machine) -> Iterator[None]:
        """What goes wrong before the run moves refuses it, or leaves it paused."""
        paused = machine.reason
        try:
            yield
        except BaseException as error:
            if self._machine is machine:
                reason = paused or (str(error) if isinstance(error, TendrilError) else "it could not be prepared")
                if machine.phase not in ASKED or isinstance(error, CommandRefused | NotAllowed):
                    self._meet(Event.REFUSED, reason)
            raise

    def _read(self, machine: Machine) -> None:
        batches = self.inbox.batches()  # before the boot: a new one is known before its rows come
        if self._procedure.rig_restarted():
            self._meet(Event.RIG_LOST, RESTARTED)
        elif self.inbox.lost:
            self._meet(Event.ROWS_LOST, "its rows were not read for 30 s")
        run, before = self._run, machine.phase
        if run is None or run.machine is not machine or machine.ended:
            return
        for rows in batches:
            run.take(rows)
        for stretch in run.notes():
            self._automatic.annotate(Approach(*stretch))
        run.recording = run.recording or self._automatic.recording()
        self._settle(before, by_row=True)

    def _judge(self, machine: Machine) -> None:
        """What ends a run, or its phase, though no row says so."""
        if self._procedure.rig_silent():
            self._meet(Event.RIG_LOST, GONE)
        if machine.phase != Phase.BREAKING and (why := self._procedure.permit_lost()):
            if self._meet(Event.LEASE_LOST, why) and machine.moving:
                self._tracker.let_hold()
        if machine.late():
            self._meet(Event.LATE, too_long(machine))

    def _meet(self, event: Event, reason: str = "") -> bool:
        assert self._machine is not None
        before = self._machine.phase
        met = self._machine.meet(event, reason)
        self._settle(before)
        return met

    def _settle(self, before: Phase, by_row: bool = False) -> None:
        """Do what the phase asks for that the run has come to."""
        machine = self._machine
        assert machine is not None
        if machine.phase == before:
            return
        if before in ASKED and machine.phase not in (Phase.REFUSED, Phase.PAUSED):
            begun = "started" if before == Phase.STARTING else "resumed"
            self._tell(f"{begun} by {self._procedure.starter.name}")
        if machine.phase == Phase.PAUSED and before == Phase.PAUSING:
            self._tell(f"paused {machine.reason}")
        for closes in CLOSES.get(machine.phase, ()):
            match closes:
                case Closes.RECORDING:
                    self._automatic.end_run()
                case Closes.RESULT:
                    self._keep_result()
                case Closes.MOTION if before in MOVING and not by_row:
                    self._tracker.let_hold()
        if machine.ended:
            self._over()
        if machine.phase == Phase.REFUSED:
            self._run = self._earlier

    def _over(self) -> None:
        self.inbox.close()
        self._procedures.remove(self._procedure)

    def _keep_result(self) -> None:
        assert self._run is not None
        result = self._run.result()
        why = f": {result.reason}" if result.reason else ""
        why += "" if result.rmse is None else f", RMSE {1e3 * result.rmse:.2f} mm"
        self._tell(f"{result.state}{why}", "warning" if result.state == "broken off" else "info")
        if (repeat := self._run.repeat()) is not None:
            self._plans.teach(self._run.about.order, repeat)
        try:
            self._results.add(result)
        except OSError as problem:
            self._events.add(f"the result of run {result.id} will not outlive this server: {problem}", "warning")

    @property
    def _procedure(self) -> _Following:
        assert self._following is not None
        return self._following

    def _require_free(self) -> None:
        machine, run = self._machine, self._run
        if machine is None or machine.ended:
            return
        if run is None or run.machine is not machine:
            raise CommandRefused("a run is being prepared; stop it first")
        raise CommandRefused(f"run {run.about.id} ({run.about.lap.name}) is {machine.phase.value}; stop it first")

    def _require_run(self) -> Run:
        self.look()
        run = self._run
        if run is None or run.machine is not self._machine or run.machine.ended:
            raise CommandRefused("no run is under way")
        return run

    def _tell(self, text: str, level: Level = "info") -> None:
        assert self._run is not None
        self._events.add(f"run {self._run.about.id} ({self._run.about.lap.name}) {text}", level)


class _Left(CommandRefused):
    """The run has left the phase in which something was waited for."""


def _kept(run: Run) -> RunState:
    """What is told to who began it; CommandRefused if they lost control before a row told of it."""
    if run.machine.phase == Phase.BREAKING:
        raise CommandRefused(where(run.machine))
    return run.state()


GivenRuns = Annotated[Runs, given(Runs)]
