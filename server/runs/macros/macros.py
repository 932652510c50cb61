"""The macro that is under way: one at a time, under the lease of who started it, ended by whatever else moves or stops
the rig.

Whose request it is is told by its permit: the steps have one of their own, which is worth nothing any more as soon as
anything else was asked for. So no step that waits in a queue can come after a stop.
"""

import asyncio
from dataclasses import dataclass, field, replace
from typing import Annotated

from controller.errors import CommandRefused, TendrilError
from controller.schema.modes import Cause, Mode, Request
from controller.schema.states import MOVING
from controller.system.tasks import Tasks
from server.access.permit import Permit, own
from server.http.given import given
from server.log.events import EventLog
from server.operate.asking import asked_for, found_in, why_over
from server.operate.operator import Operator
from server.rig.client import Rig
from server.runs.macros import messages
from server.runs.macros.acts import LATCHED, Acts
from server.runs.macros.messages import Macro, MacroState, State, Step

STOPPED = (Mode.FAULT, Mode.E_STOP, Mode.REST)
ASKED = (Cause.OPERATOR, Cause.REFERENCE_DONE)
"""Why a rig holds that does as it was told."""


@dataclass
class _Run:
    """One macro as it goes."""

    macro: Macro
    permit: Permit
    """Of who started it."""
    boot: int
    mode: Mode
    leave: Permit = field(init=False)
    """Of its steps."""
    step: int = 1
    state: State = "running"
    reason: str = ""
    overtaken: str = ""
    """What else was asked for."""
    task: asyncio.Task[None] | None = None

    def __post_init__(self) -> None:
        self.leave = replace(self.permit, objection=self._objection)

    @property
    def doing(self) -> Step:
        """The step under way, or the last one."""
        return self.macro.steps[self.step - 1]

    def view(self) -> MacroState:
        """As pages see it."""
        return MacroState(
            name=self.macro.name,
            by=self.permit.name,
            state=self.state,
            step=self.step,
            steps=len(self.macro.steps),
            doing=messages.words(self.doing),
            reason=self.reason,
        )

    def _objection(self, request: Request | None) -> str:
        """What began by its leave, as a run, does not end with it: `request` is None where that is asked."""
        if request is not None and (why := self.reason or self.overtaken):
            return f"macro {self.macro.name} has ended: {why}"
        return self.permit.objection(request)


class Macros:
    """Only the event loop uses it, but for `hear`."""

    def __init__(self, acts: Acts, rig: Rig, operator: Operator, events: EventLog) -> None:
        self._acts, self._rig, self._operator, self._events = acts, rig, operator, events
        self._tasks = Tasks(lambda text: events.add(text, "error"))
        self._run: _Run | None = None
        operator.listen(self.hear)

    def start(self, macro: Macro, permit: Permit) -> MacroState:
        """Begin with its first step; raises CommandRefused while another one runs, RigUnreachable without a rig."""
        if (before := self._under_way()) is not None:
            raise CommandRefused(f"macro {before.macro.name} runs, step {before.step}; stop it first")
        info, newest = self._rig.require_info(), self._rig.newest
        if newest is None or self._rig.boot() is None:
            raise CommandRefused("the rig does not answer")
        run = self._run = _Run(macro, permit, info.boot, Mode(int(newest[0]["mode"])))
        self._events.add(f"{permit.name}: macro {macro.name} started, {_count(len(macro.steps))}")
        self._tasks.begin(f"macro {macro.name}", self._go(run))
        return run.view()

    def stop(self, permit: Permit) -> MacroState:
        """End it, and hold what moves; raises CommandRefused when none runs."""
        run = self._under_way()
        if run is None:
            raise CommandRefused("no macro runs")
        self._end(run, f"stopped by {permit.name}")
        return run.view()

    def state(self) -> MacroState | None:
        """The macro under way, or how the last one ended; None before the first."""
        return self._run.view() if self._run else None

    def hear(self, request: Request, permit: Permit | None) -> None:
        """Something is about to be asked of the rig, in any thread: what no step asks for ends the macro."""
        run = self._run
        if run is None or run.state != "running" or permit is run.leave or run.overtaken:
            return
        run.overtaken = asked_for(request, permit)

    def look(self) -> None:
        """A job: end it where it may not go on."""
        run = self._under_way()
        if run is not None and (why := self._why_over(run)):
            self._end(run, why)

    def _under_way(self) -> _Run | None:
        run = self._run
        return run if run is not None and run.state == "running" else None

    def _why_over(self, run: _Run) -> str:
        """Why it may not go on, "" while it may."""
        by_itself = self._look_at_mode(run)
        return why_over(self._rig, run.boot, run.permit, run.overtaken) or by_itself

    def _look_at_mode(self, run: _Run) -> str:
        """Why the rig is in another mode that no step has asked for, "" where one has."""
        newest = self._rig.newest
        if newest is None:
            return ""
        mode, cause = Mode(int(newest[0]["mode"])), Cause(int(newest[0]["cause"]))
        if mode == run.mode:
            return ""
        before, run.mode = run.mode, mode
        vented = mode == Mode.VENTED and before not in LATCHED  # that was a clear, which is heard where no step asks
        held = mode == Mode.HOLD and cause not in ASKED
        return found_in(mode, cause) if mode in STOPPED or vented or held else ""

    async def _go(self, run: _Run) -> None:
        run.task = asyncio.current_task()
        try:
            for number, step in enumerate(run.macro.steps, 1):
                if why := self._why_over(run):
                    return self._end(run, why)
                run.step = number
                self._events.add(f"macro {run.macro.name}, {_where(run)}")
                await self._acts.do(step, run.leave)
        except TendrilError as error:
            self._end(run, self._why_over(run) or str(error))
        except Exception:
            self._end(run, "the step failed")
            raise
        else:
            if run.state == "running":
                run.state = "done"
                self._events.add(f"macro {run.macro.name} done")

    def _end(self, run: _Run, reason: str) -> None:
        if run.state != "running":
            return
        run.state, run.reason = "ended", reason
        self._events.add(f"macro {run.macro.name} ended at {_where(run)}: {reason}", "warning")
        if run.task is not None and run.task is not asyncio.current_task():
            run.task.cancel()
        newest = self._rig.newest
        if run.overtaken or newest is None or newest[0]["mode"] not in MOVING:
            return
        if run.permit.stands():
            self._operator.request(Request.HOLD, own())  # nobody watches over that motion any more
        else:
            self._operator.hold_left()  # who operates now may have begun another one


def _where(run: _Run) -> str:
    return f"step {run.step} of {len(run.macro.steps)}, {messages.words(run.doing)}"


def _count(steps: int) -> str:
    return "1 step" if steps == 1 else f"{steps} steps"


GivenMacros = Annotated[Macros, given(Macros)]
