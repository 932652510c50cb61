"""A step as a procedure: from VENTED, under settings of its own, and back to VENTED by each of its ends.

A fresh rig's frame and signs may be wrong, so no step leaves it in HOLD, where the operator's own settings would close
the loop: it comes to rest and vents first, then the settings are put back.
"""

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import JsonValue

from controller.arrays import Array
from controller.errors import CommandRefused
from controller.schema.actuator import Actuator
from controller.schema.commissioned import marks
from controller.schema.hardware import Drivers
from controller.schema.modes import Cause, Mode, Request
from controller.schema.parameters import RigParameters
from controller.schema.rig_file import RigFile
from server.access.permit import Permit
from server.hardware.commissioning.messages import TITLES, Progress, StartBody, StepName
from server.hardware.commissioning.store import CommissioningStore, Found, KeptResult, numbers_of, value_of
from server.hardware.first_mode.store import FirstModes
from server.log.events import words
from server.operate.procedure.motion import require_mode
from server.operate.procedure.override import BLIND
from server.operate.procedure.procedure import Procedure, Procedures
from server.rig.client import Rig
from server.rig.planner import Planner

ARM_MAX_S, ARM_RETRY_S = 5.0, 0.5
"""For so long the rig may refuse to be armed, and how often it is asked."""


@dataclass(frozen=True)
class StepContext:
    """What a step works through."""

    procedures: Procedures
    store: CommissioningStore
    planner: Planner
    drivers: Callable[[], Drivers]
    """How the rig's devices fare; it waits for the rig's answer."""
    folder: Path
    """For measured tables."""
    modes: FirstModes
    """Of each actuator of the rig."""


class StepRun(Procedure):
    """One step as it goes."""

    rests = True

    def __init__(
        self, step: StepName, body: StartBody, permit: Permit, file: RigFile, folder: Path, parts: StepContext
    ):
        """`folder` of the rig `file`. RigUnreachable before the first contact."""
        starter = replace(permit, commissioning=True)
        super().__init__(parts.procedures.context, f"commissioning, {TITLES[step]}", starter, lasting=True)
        self.step, self.body, self.file, self.folder, self.parts = step, body, file, folder, parts
        self.act: Callable[[StepRun], Awaitable[Found]]
        """What it does."""
        self.advice: Callable[[Cause], str] = lambda cause: ""
        """What to do where this cause has ended it."""
        self.doing, self.share, self.waits = "begins", 0.0, False
        self.pairs: list[JsonValue] = []
        """What was measured before and after each thing that was done: the report has them however the step ends."""
        self._found: Found | None = None

    @property
    def parameters(self) -> RigParameters:
        """Of the rig."""
        return self.info.parameters

    @property
    def actuator(self) -> Actuator:
        """That the rig believes in."""
        return self.info.parameters.actuator

    def say(self, doing: str, share: float = 0.0, waits: bool = False) -> None:
        """Let pages know."""
        self.doing, self.share, self.waits = doing, min(1.0, max(0.0, share)), waits

    def keep_pair(self, what: str, before: Array, after: Array, unit: str) -> None:
        """Keep what was measured before and after `what`, (n,) each."""
        self.pairs.append({"what": what, "before": [*numbers_of(before)], "after": [*numbers_of(after)], "unit": unit})

    def view(self) -> Progress:
        """For the page."""
        return Progress(step=self.step, doing=self.doing, share=self.share, waits=self.waits, by=self.starter.name)

    async def steps(self) -> None:
        """The one."""
        self._found = await self.act(self)

    def judged(self, mode: Mode, cause: Cause) -> str:
        """With what to do about it."""
        why = super().judged(mode, cause)
        return why and why + self.advice(cause)

    async def take_rig(self, **settings: Any) -> None:
        """Arm and follow under `settings` in place of the operator's: open loop without sensors where they leave it."""
        require_vented(self.context.rig)
        await self.override.put(**BLIND | settings)
        await self.follow(await self._arm())

    def report(self) -> None:
        """The result says it, once the rig is given back."""

    async def finish(self) -> None:
        """Keep what came of it."""
        found, title = self._found, TITLES[self.step]
        if found is None or self.state == "ended":
            found = Found(False, f"ended at “{self.doing}”: {self.reason}")
        before = {field: value_of(self.file, field) for field in found.changes}
        if self.pairs:
            found = found._replace(data=found.data | {"pairs": self.pairs})
        values = await asyncio.to_thread(self.file.values, self.folder)
        about = {"before": before, "stands_on": marks(self.step, values), "by": self.starter.name}
        result = KeptResult(**found._asdict(), **about, at=datetime.now(UTC))
        try:
            await asyncio.to_thread(self.parts.store.keep, self.step, result)
        except OSError as error:
            self.context.events.add(f"the result of {title} cannot be kept: {error.strerror}", "error")
        self.context.events.add(f"{self.title}: {found.text}", "info" if found.good else "warning")

    async def _arm(self) -> np.void:
        """Arm; after a new start of the rig its devices need a moment."""
        loop = asyncio.get_running_loop()
        end = loop.time() + ARM_MAX_S
        while True:
            try:
                return await self.ask(Request.ARM)
            except CommandRefused:
                if loop.time() > end:
                    raise
            await asyncio.sleep(ARM_RETRY_S)


def require_vented(rig: Rig) -> None:
    """Raise CommandRefused unless the rig is VENTED and its time goes on."""
    refusal = "this step begins with the rig vented, and it is in {}: let it rest first"
    require_mode(rig, (Mode.VENTED,), lambda mode: refusal.format(words(mode)))
