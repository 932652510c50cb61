"""What each step of a macro does, through the very doors by which the page does it."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass

from controller.errors import CommandRefused
from controller.schema.modes import Mode, Request
from controller.schema.states import LIVE
from server.drawing.store import Drawings
from server.operate.messages import SettingsBody
from server.operate.procedure.motion import ROW_POLL_S
from server.operate.procedure.procedure import STOPPED, Procedure
from server.recorder.by_hand import RecordingByHand
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


@dataclass(frozen=True)
class Acts:
    """The doors. `preset` gives what loading the gains of this name changes."""

    runs: Runs
    recording: RecordingByHand
    drawings: Drawings
    preset: Callable[[str], SettingsBody]

    async def do(self, step: Step | RunBody, by: Procedure) -> None:
        """Done once the rig's rows show it; TendrilError with the reason where it is refused."""
        permit, newest = by.permit, by.context.rig.newest
        mode = None if newest is None else Mode(int(newest[0]["mode"]))
        match step:
            case ArmStep():
                if mode not in LIVE:
                    await by.ask(Request.ARM)
            case HoldStep():
                if mode != Mode.HOLD:
                    await by.ask(Request.HOLD)
            case ClearStep():
                if mode in STOPPED:
                    await by.ask(Request.CLEAR)
            case RunBody():
                await self.runs.start(step, permit)
                await self._run_end()
            case ReferenceStep():
                await self.runs.start(RunBody(reference=step.name, laps=step.laps), permit)
            case DrawingStep():
                drawing = await asyncio.to_thread(self.drawings.read, step.name)
                await self.runs.start(RunBody(drawing=drawing, laps=step.laps), permit)
            case TargetStep():
                await by.ask(Request.FOLLOW, (step.x, step.y))
            case WaitStep():
                await asyncio.sleep(step.seconds)
            case RunEndStep():
                await self._run_end()
            case PresetStep():
                changes = await asyncio.to_thread(self.preset, step.name)
                await by.context.kept.change(changes, by.context.operator, permit)
            case RecordStep():
                await self.recording.begin(step.name, step.profile, permit.name)
            case RecordEndStep():
                await self.recording.end(permit.name)
            case MarkStep():
                await self.recording.mark(step.label, permit.name)

    async def _run_end(self) -> None:
        run = self._run()
        while self._run() is not None:
            await asyncio.sleep(ROW_POLL_S)
        ended = self.runs.state()
        if run is not None and ended is not None and ended.state != "done":
            raise CommandRefused(f"run {ended.id} was {ended.state}: {ended.reason}")

    def _run(self) -> RunState | None:
        """The run that is under way."""
        state = self.runs.state()
        return state if state is not None and state.state in ("approach", "running", "paused") else None
