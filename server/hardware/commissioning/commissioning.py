"""The commissioning: one step at a time, each begun, ended, accepted and taken back by the operator."""

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Annotated

from controller.errors import CommandRefused
from controller.schema.commissioned import changed_lines
from controller.schema.modes import Mode
from controller.schema.rig_file import RigFile
from controller.system.whole_file import write_whole
from server.access.permit import Permit
from server.hardware.commissioning import closed_loop, drivers, pressure, report, signs, sweep
from server.hardware.commissioning.frame import Framing
from server.hardware.commissioning.identify import identify, kept_mode
from server.hardware.commissioning.jog import Jogging
from server.hardware.commissioning.messages import (
    STEPS,
    TITLES,
    CaptureBody,
    Chamber,
    CommissioningState,
    ConfirmBody,
    StartBody,
    StepName,
)
from server.hardware.commissioning.step_run import StepContext, StepRun, require_vented
from server.hardware.commissioning.steps import STILL_STEPS, Seen, lacking, resting_on, step_view
from server.hardware.commissioning.store import KEPT_TEXT, CommissionedFile, Found, KeptResult, value_of
from server.hardware.first_mode.store import plant_of
from server.hardware.messages import RigFileState
from server.http.given import given

MEASURED = {"frame": "motion_capture.frame.measured", "pressure": "valves.measured"}
"""What going back behind these steps takes back in the rig file."""
ACTS: dict[StepName, Callable[[StepRun], Awaitable[Found]]] = {
    "drivers": drivers.do,
    "signs": signs.do,
    "pressure": pressure.do,
    "statics": sweep.statics,
    "decay": sweep.decays,
    "identify": identify,
    "closed_loop": closed_loop.do,
}
"""What each step does; jog and frame are also spoken to while they go on."""


class Commissioning:
    """Only the event loop uses it, but for `report`."""

    def __init__(self, parts: StepContext, file: CommissionedFile) -> None:
        self._parts, self._store, self._file = parts, parts.store, file
        self._context = parts.procedures.context
        self._last: StepRun | None = None
        self._jogging: Jogging | None = None
        self._framing: Framing | None = None
        self._writing = asyncio.Lock()

    @property
    def _run(self) -> StepRun | None:
        """The step under way, until the rig is given back and its result kept."""
        return None if self._last is None or self._last.over else self._last

    async def state(self) -> CommissioningState:
        """Where it stands."""
        file = await asyncio.to_thread(self._file.state)
        seen, run = self._seen(file), self._run
        missing = lacking(file)
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
            require_vented(self._context.rig)
        permit.require()
        run = StepRun(step, body, permit, file.rig, Path(file.path).parent, self._parts)
        run.act = self._act(step)
        run.advice = lambda cause: pressure.advice(step, cause, run.file.valves)
        self._last = run
        self._parts.procedures.start(run)

    def stop(self, step: StepName, permit: Permit) -> None:
        """End it; CommandRefused when it is not under way."""
        run = self._run
        if run is None or run.step != step:
            raise CommandRefused(f"{TITLES[step]} is not under way")
        permit.require()
        run.end(f"stopped by {permit.name}")

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
        """Write what `step` came to; where that changes a value, what rests on it is to be done again.

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
            await asyncio.to_thread(_require_same, step, result, file)
            await self._write_files(result)
            changed = any(value_of(file.rig, field) != value for field, value in result.changes.items())
            gone = resting_on(step) - {step} if changed else set()
            await self._file.change(_accepted(step, result, file.rig, gone), permit, step)
            await self._keep_mode(result)
            await asyncio.to_thread(self._store.forget, gone)
        self._context.events.add(f"{permit.name}: commissioning, {TITLES[step]} accepted: {result.text}")

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
        self._context.events.add(f"{permit.name}: commissioning goes back to {TITLES[step]}")

    def report(self) -> str:
        """All of it as one HTML page; reads the rig file."""
        info, file = self._context.rig.info, self._file.state()
        return report.page(file, self._store.kept, info)

    def _under_way(self, step: StepName, permit: Permit) -> StepRun:
        run = self._run
        if run is None or run.step != step or not run.running:
            raise CommandRefused(f"{TITLES[step]} is not under way: start it first")
        permit.require()
        return run

    def _require_idle(self) -> None:
        if self._run is not None:
            raise CommandRefused(f"{TITLES[self._run.step]} is under way: stop it first")

    def _seen(self, file: RigFileState) -> Seen:
        rig, row = self._context.rig, self._context.rig.newest
        mode = None if row is None or rig.boot() is None else Mode(int(row[0]["mode"]))
        info = rig.info
        in_force = file.in_force or (info is not None and info.twin)
        return Seen(file, self._store.kept.results, self._run.step if self._run else None, mode, in_force)

    def _act(self, step: StepName) -> Callable[[StepRun], Awaitable[Found]]:
        if step == "jog":
            self._jogging = Jogging()
            return self._jogging.do
        if step == "frame":
            self._framing = Framing()
            return self._framing.do
        return ACTS[step]

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
        mode = kept_mode(result, decay.at, plant_of(self._context.rig.require_info()))
        if mode is None:
            return
        try:
            await asyncio.to_thread(self._parts.modes.keep, mode)
        except OSError as error:
            self._context.events.add(f"damping and kappa cannot be kept: {error.strerror}", "error")


def _accepted(step: StepName, result: KeptResult, rig: RigFile, gone: set[StepName]) -> dict[str, object]:
    """What the rig file is to have by `result` of `step`; what rests on it and is `gone` is to be done again."""
    told = {name: text for name, text in rig.commissioned.items() if name not in gone}
    if not result.again:
        told[step] = result.text[:KEPT_TEXT]
    return {**_taken_back(rig, gone), **result.changes, "commissioned": told}


def _require_same(step: StepName, result: KeptResult, file: RigFileState) -> None:
    """CommandRefused where the file has other lines now than `result` was found with, but for those that it writes."""
    assert file.rig is not None
    lines = changed_lines(step, result.stands_on, file.rig.values(Path(file.path).parent))
    written = {f"{field}." for field in result.changes}
    if others := [line for line in lines if not any(field.startswith(f"{line}.") for field in written)]:
        raise CommandRefused(f"{' and '.join(others)} changed since {TITLES[step]} was done: do it again")


def _taken_back(rig: RigFile, gone: set[StepName]) -> dict[str, object]:
    """What the rig file is to have where the steps `gone` count as not done; nothing where it says so already."""
    left = {name: text for name, text in rig.commissioned.items() if name not in gone}
    changes: dict[str, object] = {} if left == rig.commissioned else {"commissioned": left}
    for step, field in MEASURED.items():
        if step in gone and value_of(rig, field):
            changes[field] = False
    return changes


GivenCommissioning = Annotated[Commissioning, given(Commissioning)]
