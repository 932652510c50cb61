"""One step under way: under whose permit, in which life of the rig, and why it ended."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

from controller.arrays import Array
from controller.schema.actuator import Actuator
from controller.schema.hardware import Drivers
from controller.schema.messages import RigInfo
from controller.schema.modes import Request
from controller.schema.parameters import RigParameters, Settings
from controller.schema.rig_file import RigFile
from server.access.permit import Permit
from server.commissioning.messages import Progress, StartBody, StepName
from server.operate.operator import Operator
from server.operate.settings import KeptSettings
from server.rig.client import Rig
from server.rig.history import History
from server.rig.planner import Planner

Torques = tuple[float, float]
Pressures = Array
"""(4,) of u1+, u1-, u2+, u2- [Pa]."""


@dataclass(frozen=True)
class Through:
    """What a step works through."""

    rig: Rig
    history: History
    operator: Operator
    kept: KeptSettings
    planner: Planner
    drivers: Callable[[], Drivers]
    """How the rig's devices fare; it waits for the rig's answer."""
    folder: Path
    """For measured tables."""


@dataclass
class Run:
    """One step as it goes."""

    step: StepName
    body: StartBody
    permit: Permit
    """Of who asked for it."""
    info: RigInfo
    file: RigFile
    folder: Path
    """Of the rig file."""
    before: Settings
    leave: Permit = field(init=False)
    """Of its requests."""
    follows: bool = False
    """A row has shown FOLLOW: another mode ends it."""
    moves: bool = True
    """It has the rig, or waits for it; from then on it only computes, and nothing ends it but `stop`."""
    ours: Settings | None = None
    """Settings that it has asked for last."""
    overtaken: str = ""
    """What else was asked for."""
    over: str = ""
    """Why it ended before its result, "" while it goes on."""
    doing: str = "begins"
    share: float = 0.0
    waits: bool = False
    task: asyncio.Task[None] | None = None

    def __post_init__(self) -> None:
        self.leave = replace(self.permit, objection=self._objection)

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

    def view(self) -> Progress:
        """For the page."""
        return Progress(step=self.step, doing=self.doing, share=self.share, waits=self.waits, by=self.permit.name)

    def _objection(self, request: Request | None) -> str:
        if why := self.over or self.overtaken:
            return f"this step of the commissioning has ended: {why}"
        return self.permit.objection(request)
