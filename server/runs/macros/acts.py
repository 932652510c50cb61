"""What each step of a macro does, through the very doors by which the page does it."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass

from controller.errors import CommandRefused
from controller.schema.modes import Mode, Request
from controller.schema.states import LIVE
from server.access.permit import Permit
from server.drawing.store import Drawings
from server.operate.asking import POLL, ask
from server.operate.messages import SettingsBody
from server.operate.operator import Operator, Target
from server.operate.settings import KeptSettings
from server.recorder.by_hand import RecordingByHand
from server.rig.client import Rig
from server.runs.macros.messages import (
    ArmStep,
    ClearStep,
    DrawingStep,
    HoldStep,
    MarkStep,
    PresetStep,
    RecordEndStep,
    RecordStep,
    ReferenceStep,
    RunEndStep,
    Step,
    TargetStep,
    WaitStep,
)
from server.runs.messages import RunBody, RunState
from server.runs.runs import Runs

LATCHED = (Mode.FAULT, Mode.E_STOP)


@dataclass(frozen=True)
class Acts:
    """The doors. `preset` gives what loading the gains of this name changes."""

    rig: Rig
    operator: Operator
    kept: KeptSettings
    runs: Runs
    recording: RecordingByHand
    drawings: Drawings
    preset: Callable[[str], SettingsBody]

    async def do(self, step: Step, permit: Permit) -> None:
        """Done once the rig's rows show it; TendrilError with the reason where it is refused."""
        match step:
            case ArmStep():
                if self._mode() not in LIVE:
                    await self._ask(Request.ARM, permit)
            case HoldStep():
                if self._mode() != Mode.HOLD:
                    await self._ask(Request.HOLD, permit)
            case ClearStep():
                if self._mode() in LATCHED:
                    await self._ask(Request.CLEAR, permit)
            case ReferenceStep():
                await self.runs.start(RunBody(reference=step.name, laps=step.laps), permit)
            case DrawingStep():
                drawing = await asyncio.to_thread(self.drawings.read, step.name)
                await self.runs.start(RunBody(drawing=drawing, laps=step.laps), permit)
            case TargetStep():
                await self._ask(Request.FOLLOW, permit, (step.x, step.y))
            case WaitStep():
                await asyncio.sleep(step.seconds)
            case RunEndStep():
                await self._run_end()
            case PresetStep():
                changes = await asyncio.to_thread(self.preset, step.name)
                await self.kept.change(changes, self.operator, permit)
            case RecordStep():
                await self.recording.begin(step.name, step.profile, permit.name)
            case RecordEndStep():
                await self.recording.end(permit.name)
            case MarkStep():
                await self.recording.mark(step.label, permit.name)

    def _mode(self) -> Mode | None:
        newest = self.rig.newest
        return None if newest is None else Mode(int(newest[0]["mode"]))

    async def _ask(self, request: Request, permit: Permit, target: Target | None = None) -> None:
        """Ask the rig, and wait for a row that came of it: the next step is judged by rows."""
        await ask(self.rig, self.operator, request, permit, target)

    async def _run_end(self) -> None:
        run = self._run()
        while self._run() is not None:
            await asyncio.sleep(POLL)
        ended = self.runs.state()
        if run is not None and ended is not None and ended.state != "done":
            raise CommandRefused(f"run {ended.id} was {ended.state}: {ended.reason}")

    def _run(self) -> RunState | None:
        """The run that is under way."""
        state = self.runs.state()
        return state if state is not None and state.state in ("approach", "running", "paused") else None
