"""The measurement of the first mode: small steps to either side of the rest, in open loop, under who asked for them.

The law and the open-loop torques are the measurement's while it lasts, and put back whatever ends it; no file ever has
them. It ends by whatever else is asked of the rig, as a macro does: its requests have a permit of their own.
"""

import asyncio
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from typing import Annotated

import numpy as np

from controller.errors import CommandRefused, RigUnreachable, TendrilError
from controller.schema.messages import RigInfo
from controller.schema.modes import Cause, Law, Mode, Request
from controller.system.tasks import Tasks
from server.access.permit import Permit, own
from server.http.given import given
from server.log.events import EventLog, words
from server.operate.asking import ask, asked_for, found_in, why_over
from server.operate.borrowing import Borrowing, stands_still
from server.operate.operator import Operator, Target
from server.operate.settings import KeptSettings
from server.presets.first_mode import planning
from server.presets.first_mode.messages import FirstModeBody, FirstModeState, KeptMode, MeasuredMode
from server.presets.first_mode.store import FirstModes, plant_of
from server.rig.client import Rig
from server.rig.history import Gathered, History
from server.rig.planner import Planner

STILL = 1e-3
"""The arm rests where its tip swings by less (rms) [m]."""
SHORTEST, LONGEST = 1.5, 4.0
"""A step is given so long at least, and at most [s]."""
JUDGED = ("slot", "pressure_meas", "u_hat", "p_meas")
"""What is looked at of telemetry."""


@dataclass(frozen=True)
class Parts:
    """What it works through."""

    rig: Rig
    history: History
    operator: Operator
    kept: KeptSettings
    planner: Planner
    modes: FirstModes
    events: EventLog


@dataclass
class _Run:
    """One measurement as it goes."""

    body: FirstModeBody
    permit: Permit
    """Of who asked for it."""
    info: RigInfo
    torque: float
    parts: Parts
    leave: Permit = field(init=False)
    """Of its requests."""
    borrowing: Borrowing = field(init=False)
    moves: bool = True
    """It has the rig; from then on it only computes, and nothing ends it any more."""
    follows: bool = False
    """A row has shown FOLLOW: another mode ends it."""
    state: FirstModeState = field(init=False)
    overtaken: str = ""
    """What else was asked for."""
    starts: list[tuple[float, int]] = field(default_factory=list)
    """Clock [s] and slot at which each step began, and the last one ended."""
    seen: Gathered | None = None
    """Telemetry from the first step on."""
    task: asyncio.Task[None] | None = None

    def __post_init__(self) -> None:
        self.leave = replace(self.permit, objection=self._objection)
        operator = self.parts.operator
        self.borrowing = Borrowing(operator, self.parts.kept, self.leave, operator.settings)
        steps = 2 * self.body.repeats
        self.state = FirstModeState(by=self.permit.name, state="running", doing="goes to its rest", step=0, steps=steps)

    @property
    def running(self) -> bool:
        return self.state.state == "running"

    def say(self, **changes: object) -> None:
        """Let pages know."""
        self.state = self.state.model_copy(update=changes)

    def _objection(self, request: Request | None) -> str:
        if why := self.state.reason or self.overtaken:
            return f"the measurement of the first mode has ended: {why}"
        return self.permit.objection(request)


class FirstModeMeasurement:
    """One at a time. Only the event loop uses it, but for `hear`."""

    watched = "the measurement of the first mode"

    def __init__(self, parts: Parts) -> None:
        self._parts = parts
        self._tasks = Tasks(lambda text: parts.events.add(text, "error"))
        self._run: _Run | None = None
        parts.operator.listen(self.hear)

    async def start(self, body: FirstModeBody, permit: Permit) -> FirstModeState:
        """Begin; CommandRefused while one runs and unless the rig holds or follows, ParameterError for too far."""
        self._require_ready()
        info = self._parts.rig.require_info()
        torque = await self._parts.planner.do(planning.torque, body.travel, info.parameters)
        self._require_ready()
        permit.require(Request.FOLLOW)
        run = self._run = _Run(body, permit, info, torque, self._parts)
        self._parts.events.add(f"{permit.name}: measurement of the first mode started, {run.state.steps} steps")
        self._tasks.begin("the measurement of the first mode", self._go(run))
        return run.state

    def stop(self, permit: Permit) -> FirstModeState:
        """End it, and hold; raises CommandRefused when none runs."""
        run = self._run
        if run is None or not run.running:
            raise CommandRefused("no first mode is being measured")
        self._end(run, f"stopped by {permit.name}")
        return run.state

    def state(self) -> FirstModeState | None:
        """How the last one goes, or ended; None before the first."""
        return self._run.state if self._run else None

    def hear(self, request: Request, permit: Permit | None) -> None:
        """Something is about to be asked of the rig, in any thread: what the measurement does not ask for ends it."""
        run = self._run
        if run is None or not (run.running and run.moves) or permit is run.leave or run.overtaken:
            return
        run.overtaken = asked_for(request, permit)

    def look(self) -> None:
        """Called at every beat: end it where it may not go on."""
        run = self._run
        if run is not None and run.running and run.moves and (why := self._why_over(run)):
            self._end(run, why)

    def _require_ready(self) -> None:
        rig, newest = self._parts.rig, self._parts.rig.newest
        if self._run is not None and (self._run.running or self._run.borrowing.ours is not None):
            raise CommandRefused("the first mode is being measured already; stop that first")
        if newest is None or rig.boot() is None:
            raise RigUnreachable("the rig does not answer")
        if rig.paused:
            raise CommandRefused("the twin is paused; continue it first")
        if (mode := Mode(int(newest[0]["mode"]))) not in (Mode.HOLD, Mode.FOLLOW):
            raise CommandRefused(f"the first mode is measured from HOLD or FOLLOW, and the rig is in {words(mode)}")
        if not np.isfinite(newest[0]["p_meas"]).all():
            raise CommandRefused("the first mode is measured at the tip, whose marker is not seen")

    def _why_over(self, run: _Run) -> str:
        """Why it may not go on, "" while it may."""
        rig, newest = self._parts.rig, self._parts.rig.newest
        if (why := why_over(rig, run.info.boot, run.permit, run.overtaken)) or newest is None:
            return why
        mode, cause = Mode(int(newest[0]["mode"])), Cause(int(newest[0]["cause"]))
        if run.follows and mode != Mode.FOLLOW:
            return found_in(mode, cause)
        return "the settings were changed" if run.borrowing.changed else ""

    async def _go(self, run: _Run) -> None:
        run.task = asyncio.current_task()
        try:
            await self._swing(run)
            run.moves = False
            await self._put_back(run)
            run.say(doing="finds the mode that fits")
            await self._keep(run, await self._fitted(run))
        except TendrilError as error:
            self._end(run, (run.moves and self._why_over(run)) or str(error))
        except asyncio.CancelledError:
            if run.running:
                raise
        except Exception:
            self._end(run, "it failed")
            raise
        finally:
            await self._put_back(run)

    async def _swing(self, run: _Run) -> None:
        """The steps, from the pose in which the rig holds and back to it."""
        held = await self._ask(run, Request.HOLD)
        here = (float(held["u"][0]), float(held["u"][1]))
        there, back = (run.torque, run.torque), (-run.torque, -run.torque)
        await run.borrowing.put(law=Law.OPEN_LOOP, u_open=here)
        await self._ask(run, Request.FOLLOW, (float(held["p_ref"][0]), float(held["p_ref"][1])))
        run.follows = True
        rate = run.info.parameters.controller.rest_rate
        await run.borrowing.lead(here, back, rate)
        await self._rest()
        for step in range(1, run.state.steps + 1):
            run.say(step=step, doing=f"step {step} of {run.state.steps}")
            self._begin_step(run)
            await run.borrowing.torque(there if step % 2 else back)
            await self._rest()
        self._begin_step(run)
        run.say(doing="goes back to where it held")
        await run.borrowing.lead(back, here, rate)
        run.follows = False
        await self._ask(run, Request.HOLD)

    def _begin_step(self, run: _Run) -> None:
        """Note when, and take what the one before has shown: a minute of rows is kept, and less of a fast loop."""
        run.starts.append(self._now())
        now, _ = run.starts[-1]
        if run.seen is None:
            run.seen = Gathered(self._parts.history, now, JUDGED)
        run.seen.take(now)

    async def _ask(self, run: _Run, request: Request, target: Target | None = None) -> np.void:
        return await ask(self._parts.rig, self._parts.operator, request, run.leave, target)

    async def _rest(self) -> None:
        """Wait until the arm rests, or for as long as a step is given."""
        await stands_still(self._parts.rig, self._parts.history, STILL, SHORTEST, LONGEST)

    def _now(self) -> tuple[float, int]:
        """Clock [s] and slot of the newest row."""
        newest = self._newest()
        return float(newest["t_ns"]) * 1e-9, int(newest["slot"])

    async def _fitted(self, run: _Run) -> MeasuredMode:
        assert run.seen is not None
        slots = tuple(slot for _, slot in run.starts)
        return await self._parts.planner.do(planning.measured, run.seen.rows(), slots, run.body, run.info.parameters)

    async def _keep(self, run: _Run, mode: MeasuredMode) -> None:
        info, events = run.info, self._parts.events
        kept = KeptMode(actuator=info.parameters.actuator, plant=plant_of(info), measured=datetime.now(UTC), mode=mode)
        try:
            await asyncio.to_thread(self._parts.modes.keep, kept)
        except OSError as error:
            return self._end(run, f"it cannot be kept: {error.strerror}")
        run.say(state="done", doing="done")
        zeta, kappa = mode.zeta, mode.kappa
        events.add(
            f"first mode of {info.parameters.actuator.name} measured: {mode.frequency.value:.2f} Hz, damping ratio "
            f"{zeta.value:.3f} ({zeta.low:.3f} to {zeta.high:.3f}), kappa {kappa.value:.1f} "
            f"({kappa.low:.1f} to {kappa.high:.1f})"
        )

    def _end(self, run: _Run, reason: str) -> None:
        if not run.running:
            return
        run.say(state="ended", reason=reason)
        self._parts.events.add(f"measurement of the first mode ended, {run.state.doing}: {reason}", "warning")
        if run.task is not None and run.task is not asyncio.current_task():
            run.task.cancel()

    async def _put_back(self, run: _Run) -> None:
        """Hold what still moves by it, then give back law and torques, unless somebody has changed them meanwhile."""
        operator, newest = self._parts.operator, self._parts.rig.newest
        if run.follows and not run.overtaken and newest is not None and newest[0]["mode"] == Mode.FOLLOW:
            if run.permit.stands():
                operator.request(Request.HOLD, own())
            else:
                operator.hold_left()
        await run.borrowing.give_back(("law", "u_open"))

    def _newest(self) -> np.void:
        newest = self._parts.rig.newest
        if newest is None:
            raise RigUnreachable("the rig does not answer")
        row: np.void = newest[0]
        return row


GivenMeasurement = Annotated[FirstModeMeasurement, given(FirstModeMeasurement)]
