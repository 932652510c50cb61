"""The macro that is under way: one at a time, as a procedure."""

from dataclasses import dataclass
from typing import Annotated

from controller.errors import CommandRefused
from controller.schema.modes import Cause, Mode
from server.access.permit import Permit
from server.http.given import given
from server.operate.procedure.procedure import STOPPED, Procedure, Procedures, found_in
from server.runs.macros import messages
from server.runs.macros.acts import Acts
from server.runs.macros.messages import Macro, MacroState
from server.runs.messages import RunBody

ASKED = (Cause.OPERATOR, Cause.REFERENCE_DONE)
"""Why a rig holds that does as it was told."""


@dataclass(frozen=True)
class Series:
    """Runs one after another, by one button."""

    name: str
    """Of what is followed."""
    steps: list[RunBody]


class MacroRun(Procedure):
    """One macro, or one series of runs, as it goes."""

    def __init__(self, acts: Acts, procedures: Procedures, macro: Macro | Series, permit: Permit) -> None:
        kind = "learning" if isinstance(macro, Series) else "macro"
        super().__init__(procedures.context, f"{kind} {macro.name}", permit)
        newest = self.context.rig.newest
        if newest is None or self.context.rig.boot() is None:
            raise CommandRefused("the rig does not answer")
        self._acts, self._macro, self.mode = acts, macro, Mode(int(newest[0]["mode"]))
        self.step = 1
        """The one under way, or the last one."""

    def view(self) -> MacroState:
        """As pages see it."""
        macro = self._macro
        return MacroState(
            name=macro.name,
            learning=isinstance(macro, Series),
            by=self.starter.name,
            state=self.state,
            step=self.step,
            steps=len(macro.steps),
            doing=self._words(),
            reason=self.reason,
        )

    def where(self) -> str:
        """Which step."""
        return f" at {self._doing()}"

    def judged(self, mode: Mode, cause: Cause) -> str:
        """Why the rig is in another mode that no step has asked for, "" where one has."""
        if mode == self.mode:
            return ""
        before, self.mode = self.mode, mode
        vented = mode == Mode.VENTED and before not in STOPPED  # that was a clear, which is heard where no step asks
        held = mode == Mode.HOLD and cause not in ASKED
        return found_in(mode, cause) if mode in (*STOPPED, Mode.REST) or vented or held else ""

    async def steps(self) -> None:
        """One after another."""
        for number, step in enumerate(self._macro.steps, 1):
            if why := self.why_over():
                return self.end(why)
            self.step = number
            self.context.events.add(f"{self.title}, {self._doing()}")
            await self._acts.do(step, self)

    def _doing(self) -> str:
        return f"step {self.step} of {len(self._macro.steps)}, {self._words()}"

    def _words(self) -> str:
        step = self._macro.steps[self.step - 1]
        return f"repeat {self._macro.name}" if isinstance(step, RunBody) else messages.words(step)


class Macros:
    """At most one runs."""

    def __init__(self, acts: Acts, procedures: Procedures) -> None:
        self._acts, self._procedures = acts, procedures
        self._run: MacroRun | None = None

    def start(self, macro: Macro | Series, permit: Permit) -> MacroState:
        """Begin with its first step; raises CommandRefused while another one runs, RigUnreachable without a rig."""
        if self._run is not None and self._run.running:
            raise CommandRefused(f"{self._run.title} runs, step {self._run.step}; stop it first")
        run = self._run = MacroRun(self._acts, self._procedures, macro, permit)
        steps = len(macro.steps)
        self._procedures.start(run, ", 1 step" if steps == 1 else f", {steps} steps")
        return run.view()

    def stop(self, permit: Permit) -> MacroState:
        """End it, and hold what moves; raises CommandRefused when none runs."""
        if self._run is None or not self._run.running:
            raise CommandRefused("no macro runs")
        self._run.end(f"stopped by {permit.name}")
        return self._run.view()

    def state(self) -> MacroState | None:
        """The macro under way, or how the last one ended; None before the first."""
        return self._run.view() if self._run else None


GivenMacros = Annotated[Macros, given(Macros)]
