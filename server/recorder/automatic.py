"""Recordings that no one presses a button for: of a run, of a fault, and what a killed process left unfinished."""

import asyncio
import time
from collections.abc import Callable
from dataclasses import dataclass

from controller.errors import RecordingError, TendrilError
from controller.schema.modes import Cause, Mode
from controller.schema.parameters import Settings
from controller.system.scheduler import Scheduler
from recordings.format.annotations import Annotation
from recordings.format.messages import FAULT, Recording, by_itself
from recordings.write.session import Context
from server.log.events import EventLog, words
from server.operate.procedure.procedure import STOPPED
from server.recorder.client import Interrupted, RecorderClient
from server.recorder.review import Review
from server.rig.client import Rig

AFTER = 10.0
"""So long after a fault the recording of it ends, whatever it was begun for [s]."""
CALM = (None, Mode.VENTED, *STOPPED)
"""From these a fault or stop says nothing about a motion."""


@dataclass
class _OfRun:
    """The recording of a run: its id, "" until it has begun, and whether the run is over."""

    id: str = ""
    over: bool = False


class Automatic:
    """Only the event loop uses it; whatever waits for the recorder does so in a task.

    `faults` says at every fault whether it is recorded.
    """

    def __init__(
        self,
        recorder: RecorderClient,
        rig: Rig,
        review: Review,
        events: EventLog,
        settings: Callable[[], Settings],
        faults: Callable[[], bool],
        scheduler: Scheduler,
    ) -> None:
        self._recorder, self._rig, self._review, self._events = recorder, rig, review, events
        self._settings, self._faults = settings, faults
        self._mode: Mode | None = None
        self._run = _OfRun()
        self._until = 0.0
        """Until then what follows a fault is recorded [s, `time.monotonic`]."""
        self._lasting = self._stopped = ""
        """Ids of the recording that ends when all of that is in it, and of the one that was ended last."""
        self._ending = asyncio.Lock()
        """Held while a recording is ended: a run that follows at once would else go into the one of the run before."""
        self._scheduler = scheduler

    def recording(self) -> str | None:
        """Id of the recording that goes on; None without one."""
        state = self._recorder.state()
        return state.id if state.recording else None

    def look(self) -> None:
        """A fault under pressure begins a recording, and what a killed process was writing goes on."""
        self._look_for_fault()
        if self._rig.newest is None or self._rig.boot() is None:
            return
        if interrupted := self._review.take_interrupted():
            self._scheduler.begin("the rest of a recording", self._go_on(interrupted, by_itself(interrupted)))
        if killed := self._recorder.take_interrupted():
            self._scheduler.begin("the rest of a recording", self._resume(killed))
        if left := self._recorder.take_left():
            self._adopt(left)

    def _look_for_fault(self) -> None:
        newest = self._rig.newest
        before, self._mode = self._mode, None if newest is None else Mode(int(newest[0]["mode"]))
        if newest is not None and self._faults() and self._mode in STOPPED and before not in CALM:
            self._until = time.monotonic() + AFTER
            if not self.recording():
                self._scheduler.begin("the recording of a fault", self._record_fault(Cause(int(newest[0]["cause"]))))

    async def begin_run(self, name: str, operator: str) -> None:
        """Record a run from now on, unless a recording of someone goes on.

        A run that is over before its recording has begun cancels this, but not a recorder at work: see `end_run`.
        """
        run = self._run = _OfRun()
        await self._scheduler.to_its_end("the recording of a run", self._record_run(run, name, operator))

    def annotate(self, annotation: Annotation) -> None:
        """Note it in the recording that goes on, if any."""
        self._recorder.annotate(annotation)

    def end_run(self) -> None:
        """The run is over, and so is the recording that was begun for it, or that begins at this moment.

        Where a fault has ended the run, what follows it is recorded, too.
        """
        self._look_for_fault()
        run, self._run = self._run, _OfRun()
        run.over = True
        if run.id:
            self._end_later(run.id)

    async def _record_run(self, run: _OfRun, name: str, operator: str) -> None:
        async with self._ending:
            if self._lasting:
                await self._end(self._lasting)
            self._until = time.monotonic()  # what was before the run does not make its recording longer
            if self.recording() is None and not run.over:
                run.id = await self._start(name, Context(profile="standard", operator=operator, reference=name))
            if run.id and run.over:
                self._end_later(run.id)

    async def _record_fault(self, cause: Cause) -> None:
        if id := await self._start(f"{FAULT}{words(cause)}", Context(profile="standard")):
            self._end_later(id)

    def _adopt(self, left: Recording) -> None:
        """The server that began it was killed, and the recorder went on: not for long where a run or fault began it."""
        self._events.add(f"recording {left.id} goes on: the server that began it was killed")
        if by_itself(left):
            self._until = time.monotonic() + AFTER
            self._end_later(left.part_of or left.id)

    async def _resume(self, killed: Interrupted) -> None:
        """The process that wrote it was killed, and nothing else: what is recorded may last."""
        await self._go_on(killed.recording, killed.ending)
        self._review.cut_off(killed.recording.id)

    async def _go_on(self, interrupted: Recording, over: bool) -> None:
        """Go on with what a killed process has left, where it ends; not for long where that is `over`."""
        first = interrupted.part_of or interrupted.id
        try:
            context = await asyncio.to_thread(self._rest, interrupted, first)
        except TendrilError as error:
            return self._events.add(f"recording {interrupted.id} ends where it was cut off: {error}", "warning")
        if await self._start(interrupted.name, context) and (over or self._stopped == first):
            self._until = time.monotonic() + AFTER
            self._end_later(first)

    def _rest(self, interrupted: Recording, first: str) -> Context:
        """How it goes on: with all that the rig's ring still holds of it; TendrilError when it cannot."""
        boot, after = self._review.end_of(interrupted)
        if self._rig.newest is None or self._rig.info is None or self._rig.info.boot != boot:
            raise RecordingError("the rig restarted since")
        return Context(interrupted.profile, interrupted.operator, interrupted.reference, first, after=after)

    async def _start(self, name: str, context: Context) -> str:
        """Id of the recording, "" when it could not begin: the log says why, and nothing else waits for it."""
        try:
            if self._rig.info is None:
                raise RecordingError("no rig was heard yet")
            state = await asyncio.to_thread(self._recorder.start, name, self._rig.info, self._settings(), context)
        except RecordingError as error:
            self._events.add(f"{name} is not recorded: {error}", "warning")
            return ""
        lost = f", {state.gaps} ticks are lost" if state.gaps else ""
        how = f"goes on after {context.part_of}{lost}" if context.part_of else "started by itself"
        self._events.add(f"recording {state.id} {how}", "warning" if state.gaps else "info")
        return state.id

    def _end_later(self, id: str) -> None:
        """End the recording whose first part is `id` once all that follows a fault is in it, at once without one."""
        self._lasting = id
        self._scheduler.begin("the end of a recording", self._last(id))

    async def _last(self, id: str) -> None:
        while (left := self._until - time.monotonic()) > 0:  # another fault may come meanwhile
            await asyncio.sleep(left)
        async with self._ending:
            await self._end(id)

    async def _end(self, id: str) -> None:
        """End the recording whose first part is `id`, unless someone has ended it already; within `_ending`."""
        self._lasting, self._stopped = "", id
        if self._recorder.first() != id:
            return
        try:
            done = await asyncio.to_thread(self._recorder.stop)
        except RecordingError as error:
            return self._events.add(str(error), "warning")
        self._review.stopped(done.id)
        self._events.add(f"recording {done.id} ended, {done.rows} rows, {done.gaps} gaps")
