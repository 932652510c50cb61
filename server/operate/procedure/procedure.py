"""One engine for all that takes the rig, does steps and gives it back. A new procedure is its steps:

    class Nudge(Procedure):
        async def steps(self) -> None:
            held = await self.ask(Request.HOLD)
            here = (float(held["u"][0]), float(held["u"][1]))
            await self.override.put(law=Law.OPEN_LOOP, u_open=here)
            await self.follow(held)
            await self.lead(here, (0.01, 0.0))
            self.outcome = f"the tip went to {self.tip(0.2)}"

    procedures.start(Nudge(procedures.context, "nudge", permit))

The engine does the rest. Requests go under a permit derived from the starter's, which is worth nothing any more once
the procedure is over: no step that waits in a queue comes after a stop. It ends by `end`, by what others ask of the
rig, with its starter's lease, session or presence, with the rig (restarted, silent, FAULT, E-STOP), with the server, by
an error, and by a change of the settings that it overrides. Then what moves is held, or comes to rest and vents
(`rests`), the settings are put back, and the log has the reason.
"""

import asyncio
import contextlib
import time
from collections.abc import Callable
from typing import Literal

from controller.errors import TendrilError
from controller.schema.modes import Cause, Mode, Request
from controller.schema.states import LIVE, MOVING
from controller.system.scheduler import Scheduler
from server.access.permit import Permit, own
from server.log.events import words
from server.operate.procedure.motion import POLL_S, Context, Motion
from server.operate.procedure.override import RETRY_S

REST_MAX_S = 30.0
"""Longest wait until the rig is vented; it goes on to rest by itself."""
LEAVE_MAX_S = 2.0
"""Longest wait of a server that ends until settings are put back; what is left of it the next one does."""
ORPHANED_TRACKING_S = 0.5
"""A rig that tracks though no procedure has it do so is held after so long, and again every RETRY_S."""
GONE, RESTARTED = "the rig is gone", "the rig restarted"
STOPPED = (Mode.FAULT, Mode.E_STOP)
SERVER_ENDED = "the server ended"

State = Literal["running", "done", "ended"]
"""Done: to its last step; ended: before that."""


class Procedure(Motion):
    """One use of the rig. Only the event loop uses it, but for `hear`."""

    silence_max_s = 0.0
    """For how long the rig may be silent; 0: for as long as it counts as connected."""
    rests = False
    """At its end the rig comes to rest and vents; else what moves is held."""

    def __init__(self, context: Context, title: str, starter: Permit, lasting: bool = False) -> None:
        """`title` for the log; `lasting`: the next server puts back what this one could not. RigUnreachable."""
        super().__init__(context, context.rig.require_info(), starter.derived(self._objection), lasting)
        self.title, self.starter = title, starter
        self.state: State = "running"
        self.reason = ""
        """Why it ended before its last step."""
        self.outcome = f"{title} done"
        """What the log has once it is done."""
        self.has_rig = True
        """Without, it only computes: what becomes of the rig does not end it any more."""
        self.over = False
        """The rig is given back."""
        self._overtaken = ""
        """What else was asked for."""
        self._steps: asyncio.Task[None] | None = None

    @property
    def running(self) -> bool:
        """Whether its steps go on."""
        return self.state == "running"

    async def steps(self) -> None:
        """All of it, up to where the rig may be given back. A TendrilError ends it with its text."""
        raise NotImplementedError

    def where(self) -> str:
        """How far it is, for the log: what stands after "ended"."""
        return ""

    def judged(self, mode: Mode, cause: Cause) -> str:
        """Why the rig's newest row ends it, "" where it may go on."""
        stopped = self.override.ours is not None and mode in STOPPED
        if stopped or (self.follows and mode != Mode.FOLLOW):
            return found_in(mode, cause)
        return "the settings were changed" if self.override.changed else ""

    def report(self) -> None:
        """Tell the log what it came to, or why not."""
        if self.state == "done":
            return self.context.events.add(self.outcome)
        self.context.events.add(f"{self.title} ended{self.where()}: {self.reason}", "warning")

    async def finish(self) -> None:
        """What is left to do once the rig is given back, by each end."""

    @property
    def tracks(self) -> bool:
        """Whether it has the rig in TRACK, or may."""
        return False

    def permit_lost(self) -> str:
        """Why its starter may not go on with it, "" otherwise."""
        return "" if self.starter.stands() else f"{self.starter.name} no longer operates"

    def rig_restarted(self) -> bool:
        """Whether this is another boot than that in which it began."""
        return self.context.rig.info is not None and self.context.rig.info.boot != self.info.boot

    def rig_silent(self) -> bool:
        """Whether no telemetry has come for too long."""
        rig = self.context.rig
        return rig.age > self.silence_max_s if self.silence_max_s else rig.boot() is None or rig.newest is None

    def why_over(self) -> str:
        """Why it may not go on, "" while it may."""
        if why := self.permit_lost():
            return why
        if self.rig_restarted() or self.rig_silent():
            return RESTARTED if self.rig_restarted() else GONE
        row = self.row()
        return self._overtaken or self.judged(Mode(int(row["mode"])), Cause(int(row["cause"])))

    def hear(self, request: Request, permit: Permit | None) -> None:
        """Something is about to be asked of the rig, in any thread: what no step asks for ends it."""
        if self.running and self.has_rig and permit is not self.permit and not self._overtaken:
            what = request.name.replace("_", "-") if request != Request.NONE else "another target"
            self._overtaken = what if permit is None else f"{what}, asked for by {permit.name}"

    def look(self) -> None:
        """A job: end it where it may not go on."""
        if self.running and self.has_rig and (why := self.why_over()):
            self.end(why)

    def end(self, reason: str) -> None:
        """End it before its last step; nothing where it is over by then."""
        if not self.running:
            return
        self.state, self.reason = "ended", reason
        self.report()
        if self._steps is not None and self._steps is not asyncio.current_task():
            self._steps.cancel()
        if self.has_rig and not self.rests and not self._overtaken:
            self._halt()

    def leave(self) -> bool:
        """The server is about to end: so do steps, while the rig still hears. Whether it is worth to wait for them."""
        if self._steps is not None:
            self.end(SERVER_ENDED)
        return not self.running

    def close(self) -> None:
        """The server has ended, and its link with it."""

    async def go(self) -> None:
        """From the first step to when the rig is given back."""
        self._steps = asyncio.current_task()
        try:
            await self.steps()
            if self.running:
                self.state = "done"
                self.report()
        except TendrilError as error:
            self.end((self.has_rig and self.why_over()) or str(error))
        except asyncio.CancelledError:
            if self.running:
                self.end(SERVER_ENDED)
                raise
        except Exception:
            self.end("the step failed")
            raise
        finally:
            self._steps = None  # nothing interrupts what follows
            self.has_rig = False
            await self.give_back()
            await self.finish()

    async def give_back(self) -> None:
        """Put the operator's settings back; where it `rests`, once the rig is vented."""
        self.follows = False
        if self.override.ours is None:
            return
        self.override.returning = True
        if self.rests:
            await self._rest()
        await self.override.restore()

    def _halt(self) -> None:
        newest = self.context.rig.newest
        if newest is None or newest[0]["mode"] not in MOVING:
            return
        if self.starter.stands():
            self.context.operator.request(Request.HOLD, own())  # no step watches over that motion any more
        else:
            self.context.operator.hold_left()  # who operates now may have begun another one

    async def _rest(self) -> None:
        """Let what was armed come to rest and vent; one that was stopped or restarted has done so itself.

        A silent one may hold as it did: it is waited for.
        """
        rig, loop = self.context.rig, asyncio.get_running_loop()
        end, again = loop.time() + REST_MAX_S, 0.0
        while loop.time() < end and (boot := rig.boot()) in (None, self.info.boot):
            mode = None if boot is None or rig.newest is None else Mode(int(rig.newest[0]["mode"]))
            if mode not in (*LIVE, Mode.REST, None):
                return
            if mode in LIVE and loop.time() > again:
                again = loop.time() + RETRY_S
                with contextlib.suppress(TendrilError):
                    permit = own() if self.permit.objection(Request.REST) else self.permit
                    await asyncio.wrap_future(self.context.operator.request(Request.REST, permit))
            await asyncio.sleep(POLL_S)

    def _objection(self, request: Request | None) -> str:
        """What began by its permit, as a run, does not end with it: `request` is None where that is asked."""
        if request is not None and (why := self.reason or self._overtaken):
            return f"{self.title} has ended: {why}"
        return self.starter.objection(request)


class Procedures:
    """Those under way. Only the event loop uses it, but for `hear`."""

    def __init__(self, context: Context, scheduler: Scheduler, clock: Callable[[], float] = time.monotonic) -> None:
        self.context, self._scheduler, self._clock = context, scheduler, clock
        self._orphaned_at = 0.0
        self._under_way: tuple[Procedure, ...] = ()
        context.operator.listen(self.hear)

    def start(self, procedure: Procedure, about: str = "") -> None:
        """Begin with its first step; `about` it for the log."""
        self.context.events.add(f"{procedure.starter.name}: {procedure.title} started{about}")
        self._begin(procedure)

    def hear(self, request: Request, permit: Permit | None) -> None:
        """Something is about to be asked of the rig, in any thread."""
        for one in self._under_way:
            one.hear(request, permit)

    def look(self) -> None:
        """A job: end what may not go on; put back what an earlier server has overridden."""
        failures = []
        for one in self._under_way:
            try:
                one.look()
            except Exception as error:  # one that fails ends no other
                failures.append(error)
        self._look_for_orphaned_tracking()
        note = self.context.note
        if not self._under_way and note is not None and note.overridden is not None:
            if self.context.rig.boot() is not None and self.context.rig.info is not None:
                self._begin(_Recovery(self.context))
        if failures:
            raise failures[0]

    async def leave(self) -> None:
        """The server is about to end: end all steps, and put back what they have overridden, in LEAVE_MAX_S at most."""
        end = self._clock() + LEAVE_MAX_S
        while any([one.leave() for one in self._under_way]) and self._clock() < end:
            await asyncio.sleep(POLL_S)

    def close(self) -> None:
        """The server has ended; from any thread."""
        for one in self._under_way:
            one.close()

    def add(self, procedure: Procedure) -> None:
        """It is under way, and its steps are led by others, who `remove` it."""
        self._under_way += (procedure,)

    def remove(self, procedure: Procedure) -> None:
        """It is over."""
        procedure.over = True
        self._under_way = tuple(one for one in self._under_way if one is not procedure)

    def _begin(self, procedure: Procedure) -> None:
        self.add(procedure)
        self._scheduler.begin(procedure.title, self._go(procedure))

    async def _go(self, procedure: Procedure) -> None:
        try:
            await procedure.go()
        finally:
            self.remove(procedure)

    def _look_for_orphaned_tracking(self) -> None:
        """Nothing tracks by itself: the answer to a request may have been lost, or a server have ended."""
        if any(one.tracks for one in self._under_way):
            return
        now, rig = self._clock(), self.context.rig
        if rig.newest is None or rig.newest[0]["mode"] != Mode.TRACK or rig.trouble:
            self._orphaned_at = now + ORPHANED_TRACKING_S
        elif now > self._orphaned_at:
            self._orphaned_at = now + RETRY_S
            self.context.events.add("the rig tracks though no run is under way: hold", "warning")
            self.context.operator.request(Request.HOLD, own())


class _Recovery(Procedure):
    """An earlier server ended in the middle: let the rig vent, then put the operator's settings back."""

    rests = True

    def __init__(self, context: Context) -> None:
        super().__init__(context, "the settings that a step had overridden", own(), lasting=True)
        assert context.note is not None
        self.override.before, self.override.ours = context.note.overridden, context.operator.settings
        self.has_rig = False

    async def steps(self) -> None:
        """None: only what follows them."""

    def report(self) -> None:
        """Said once it is so."""

    async def finish(self) -> None:
        """Now it is."""
        self.context.events.add("the settings that a step of the commissioning had overridden are put back", "warning")


def found_in(mode: Mode, cause: Cause) -> str:
    """The rig is in another mode than it should be."""
    return f"the rig is in {words(mode)} ({words(cause)})"
