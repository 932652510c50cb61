"""The commissioning as a state machine: one step at a time, each begun, ended, accepted and taken back by the operator.

A step's settings and torques are its own while it lasts (`motion.py`). It ends by whatever else is asked of the rig, as
a macro does: its requests have a permit of their own.
"""

import asyncio
from collections.abc import Awaitable, Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

from controller.errors import CommandRefused, TendrilError
from controller.schema.modes import Cause, Mode, Request
from controller.schema.rig_file import RigFile
from controller.system.tasks import Tasks
from controller.system.whole_file import write_whole
from server.access.permit import Permit, own
from server.commissioning import closed_loop, drivers, frame, pressure, report, sweep
from server.commissioning.frame import Framing
from server.commissioning.identify import identify, kept_mode
from server.commissioning.jog import Jogging
from server.commissioning.messages import (
    STEPS,
    TITLES,
    CaptureBody,
    Chamber,
    CommissioningState,
    ConfirmBody,
    StartBody,
    StepName,
)
from server.commissioning.motion import Motion, Run, Through, put_back, require_vented, rest
from server.commissioning.steps import STILL_STEPS, Seen, lacking, resting_on, step_view
from server.commissioning.store import KEPT_TEXT, CommissionedFile, CommissioningStore, Found, KeptResult, value_of
from server.hardware.messages import RigFileState
from server.http.given import given
from server.log.events import EventLog
from server.operate.asking import asked_for, found_in, why_over
from server.operate.borrowing import Borrowing
from server.presets.first_mode.store import plant_of

MEASURED = {"frame": "motion_capture.frame.measured", "pressure": "valves.measured"}
"""What going back behind these steps takes back in the rig file."""
Act = Callable[[Run, Motion], Awaitable[Found]]


class Commissioning:
    """Only the event loop uses it, but for `hear` and `report`."""

    def __init__(self, through: Through, store: CommissioningStore, file: CommissionedFile, events: EventLog) -> None:
        self._through, self._store, self._file, self._events = through, store, file, events
        self._tasks = Tasks(lambda text: events.add(text, "error"))
        self._run: Run | None = None
        self._jogging: Jogging | None = None
        self._framing: Framing | None = None
        self._writing = asyncio.Lock()
        self._returning = False
        through.operator.listen(self.hear)

    async def state(self) -> CommissioningState:
        """Where it stands."""
        file = await asyncio.to_thread(self._file.state)
        seen, run = self._seen(file), self._run
        missing = lacking(file.rig)
        return CommissioningState(
            available=file.rig is not None and not file.reason,
            reason=file.reason,
            rig=file.rig.name if file.rig else "",
            steps=[step_view(step, seen) for step in STEPS],
            running=run.view() if run else None,
            jog=self._jogging.view() if self._jogging else None,
            captured=self._framing.captured() if self._framing else [],
            complete=file.rig is not None and not missing,
            missing=missing,
        )

    async def start(self, step: StepName, body: StartBody, permit: Permit) -> None:
        """Begin `step`; CommandRefused says what is missing, RigUnreachable where the rig does not answer."""
        file = await asyncio.to_thread(self._file.state)
        view = step_view(step, self._seen(file))
        if view.needs or file.rig is None:
            raise CommandRefused("; ".join(view.needs))
        if step not in STILL_STEPS:
            require_vented(self._through)
        permit.require()
        info = self._through.rig.require_info()
        run = Run(step, body, permit, info, file.rig, Path(file.path).parent, self._through)
        act = self._act(run)  # may refuse
        self._run = run
        self._events.add(f"{permit.name}: commissioning, {TITLES[step]} started")
        self._tasks.begin(f"commissioning, {TITLES[step]}", self._go(run, act))

    def stop(self, step: StepName, permit: Permit) -> None:
        """End it; CommandRefused when it is not under way."""
        run = self._run
        if run is None or run.step != step:
            raise CommandRefused(f"{TITLES[step]} is not under way")
        permit.require()
        self._end(run, f"stopped by {permit.name}")

    def jog(self, chamber: Chamber | None, permit: Permit) -> None:
        """Fill `chamber` for another moment, or let go; CommandRefused unless the jog step is under way."""
        self._under_way("jog", permit)
        assert self._jogging is not None
        self._jogging.hold(chamber)

    def confirm(self, body: ConfirmBody, permit: Permit) -> None:
        """Which chamber filled; CommandRefused unless it was jogged."""
        self._under_way("jog", permit)
        assert self._jogging is not None
        self._jogging.confirm(body.commanded, body.filled)

    async def capture(self, body: CaptureBody, permit: Permit) -> None:
        """Capture a point of the frame; CommandRefused where it is not seen."""
        run = self._under_way("frame", permit)
        assert self._framing is not None
        await self._framing.capture(body, run)

    async def accept(self, step: StepName, permit: Permit) -> None:
        """Write what `step` came to; where that changes a value, what rests on it is to be done anew.

        CommandRefused unless it is done, ParameterError where the file cannot have it.
        """
        async with self._writing:
            result = self._store.kept.results.get(step)
            self._require_idle()
            if result is None or not result.good:
                why = f": {result.text}" if result else ""
                raise CommandRefused(f"{TITLES[step]} has no result to accept{why}")
            file = await asyncio.to_thread(self._file.state)
            if file.rig is None:
                raise CommandRefused(file.reason)
            await self._write_files(result)
            anew = any(value_of(file.rig, field) != value for field, value in result.changes.items())
            gone = resting_on(step) - {step} if anew else set()
            await self._file.change(_accepted(step, result, file.rig, gone), permit)
            await self._keep_mode(result)
            await asyncio.to_thread(self._store.forget, gone)
        self._events.add(f"{permit.name}: commissioning, {TITLES[step]} accepted: {result.text}")

    async def back(self, step: StepName, permit: Permit) -> None:
        """Forget what `step` came to, and what rests on it; CommandRefused while a step is under way."""
        async with self._writing:
            self._require_idle()
            gone = resting_on(step)
            file = await asyncio.to_thread(self._file.state)
            if file.rig is not None and (changes := _taken_back(file.rig, gone)):
                await self._file.change(changes, permit)
            permit.require()
            try:
                await asyncio.to_thread(self._store.forget, gone)
            except OSError as error:
                raise CommandRefused(f"it cannot be forgotten: {error.strerror}") from error
        if "jog" in gone:
            self._jogging = None
        if "frame" in gone:
            self._framing = None
        self._events.add(f"{permit.name}: commissioning goes back to {TITLES[step]}")

    def report(self) -> str:
        """All of it as one HTML page; reads the rig file."""
        info, file = self._through.rig.info, self._file.state()
        return report.page(file, self._store.kept, info)

    def hear(self, request: Request, permit: Permit | None) -> None:
        """Something is about to be asked of the rig, in any thread: what no step asks for ends it."""
        run = self._run
        if run is None or run.over or not run.moves or permit is run.leave or run.overtaken:
            return
        run.overtaken = asked_for(request, permit)

    def look(self) -> None:
        """A job: end what may not go on; give back what an earlier server has borrowed."""
        run = self._run
        if run is not None:
            if not run.over and (why := self._why_over(run)):
                self._end(run, why)
        elif self._store.kept.borrowed is not None and not self._returning and self._through.rig.boot() is not None:
            self._returning = True
            self._tasks.begin("the settings that a step had borrowed", self._give_back())

    def _under_way(self, step: StepName, permit: Permit) -> Run:
        run = self._run
        if run is None or run.step != step or run.over:
            raise CommandRefused(f"{TITLES[step]} is not under way: start it first")
        permit.require()
        return run

    def _require_idle(self) -> None:
        if self._run is not None:
            raise CommandRefused(f"{TITLES[self._run.step]} is under way: stop it first")

    def _seen(self, file: RigFileState) -> Seen:
        rig, row = self._through.rig, self._through.rig.newest
        mode = None if row is None or rig.boot() is None else Mode(int(row[0]["mode"]))
        info = rig.info
        in_force = file.in_force or (info is not None and info.twin)
        return Seen(file, self._store.kept.results, self._run.step if self._run else None, mode, in_force)

    def _act(self, run: Run) -> Act:
        """What `run` does; jog and frame are also spoken to while they go on."""
        through = self._through
        if run.step == "jog":
            self._jogging = Jogging()
            return self._jogging.do
        if run.step == "frame":
            self._framing = Framing(through)
            return self._framing.do
        acts: dict[StepName, Act] = {
            "drivers": lambda run, motion: drivers.do(run, through),
            "signs": frame.signs,
            "pressure": lambda run, motion: pressure.do(run, motion, through),
            "statics": lambda run, motion: sweep.statics(run, motion, through),
            "decay": lambda run, motion: sweep.decays(run, motion, through),
            "identify": lambda run, motion: identify(run, through, self._store.kept.results),
            "closed_loop": lambda run, motion: closed_loop.do(run, motion, through),
        }
        return acts[run.step]

    def _why_over(self, run: Run) -> str:
        """Why it may not go on, "" while it may."""
        rig, newest = self._through.rig, self._through.rig.newest
        if not run.moves:
            return ""
        if (why := why_over(rig, run.info.boot, run.permit, run.overtaken)) or newest is None:
            return why
        mode, cause = Mode(int(newest[0]["mode"])), Cause(int(newest[0]["cause"]))
        stopped = run.borrowing.ours is not None and mode in (Mode.FAULT, Mode.E_STOP)
        if stopped or (run.follows and mode != Mode.FOLLOW):
            hint = pressure.advice(run.step, cause, run.file.valves)
            return found_in(mode, cause) + hint
        return "the settings were changed" if run.borrowing.changed and not run.returning else ""

    async def _go(self, run: Run, act: Act) -> None:
        run.task = asyncio.current_task()
        motion, found = Motion(self._through, self._store, run), None
        try:
            found = await act(run, motion)
        except TendrilError as error:
            run.over = run.over or self._why_over(run) or str(error)
        except asyncio.CancelledError:
            if not run.over:
                raise
        except Exception:
            run.over = run.over or "it failed"
            raise
        finally:
            run.moves = False
            try:
                await motion.end()
                await self._settle(run, found)
            finally:
                self._run = None

    async def _settle(self, run: Run, found: Found | None) -> None:
        """Keep what came of it."""
        if found is None or run.over:
            found = Found(False, f"ended at “{run.doing}”: {run.over or 'it failed'}")
        before = {field: value_of(run.file, field) for field in found.changes}
        result = KeptResult(**found._asdict(), before=before, by=run.permit.name, at=datetime.now(UTC))
        try:
            await asyncio.to_thread(self._store.keep, run.step, result)
        except OSError as error:
            self._events.add(f"the result of {TITLES[run.step]} cannot be kept: {error.strerror}", "error")
        self._events.add(f"commissioning, {TITLES[run.step]}: {found.text}", "info" if found.good else "warning")

    def _end(self, run: Run, reason: str) -> None:
        if run.over:
            return
        run.over = reason
        if run.task is not None and run.task is not asyncio.current_task():
            run.task.cancel()

    async def _write_files(self, result: KeptResult) -> None:
        """What lies beside the rig file and is named in it."""
        name, text = result.data.get("file"), result.data.get("text")
        if not isinstance(name, str) or not isinstance(text, str):
            return
        path = Path((await asyncio.to_thread(self._file.state)).path).parent / name
        try:
            await asyncio.to_thread(write_whole, path, text)
        except OSError as error:
            raise CommandRefused(f"{path} cannot be written: {error.strerror}") from error

    async def _keep_mode(self, result: KeptResult) -> None:
        """Let what rests on damping and kappa, as the gains' margins, have them as measured."""
        decay = self._store.kept.results.get("decay", result)
        mode = kept_mode(result, decay.at, plant_of(self._through.rig.require_info()))
        if mode is None:
            return
        try:
            await asyncio.to_thread(self._through.modes.keep, mode)
        except OSError as error:
            self._events.add(f"damping and kappa cannot be kept: {error.strerror}", "error")

    async def _give_back(self) -> None:
        """An earlier server ended in the middle of a step: let the rig vent, then put the operator's settings back."""
        through, borrowed = self._through, self._store.kept.borrowed
        try:
            boot, ours = through.rig.boot(), through.operator.settings
            if borrowed is not None and boot is not None:
                await rest(through, boot, own())
                await put_back(Borrowing(through.operator, through.kept, own(), borrowed, ours), self._store)
                self._events.add("the settings that a step of the commissioning had borrowed are put back", "warning")
        finally:
            self._returning = False


def _accepted(step: StepName, result: KeptResult, rig: RigFile, gone: set[StepName]) -> dict[str, object]:
    """What the rig file is to have by `result` of `step`; what rests on it and is `gone` is to be done anew."""
    told = {name: text for name, text in rig.commissioned.items() if name not in gone}
    if not result.again:
        told[step] = result.text[:KEPT_TEXT]
    return {**_taken_back(rig, gone), **result.changes, "commissioned": told}


def _taken_back(rig: RigFile, gone: set[StepName]) -> dict[str, object]:
    """What the rig file is to have where the steps `gone` count as not done; nothing where it says so already."""
    left = {name: text for name, text in rig.commissioned.items() if name not in gone}
    changes: dict[str, object] = {} if left == rig.commissioned else {"commissioned": left}
    for step, field in MEASURED.items():
        if step in gone and value_of(rig, field):
            changes[field] = False
    return changes


GivenCommissioning = Annotated[Commissioning, given(Commissioning)]
