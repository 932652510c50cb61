"""The rig in a step's hands: from VENTED, under settings of its own, and back to VENTED, whatever ends it.

A fresh rig's frame and signs may be wrong, so no step leaves it in HOLD, where the operator's own settings would close
the loop: it comes to rest and vents first, then the settings are put back.
"""

import asyncio
import contextlib
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from controller.arrays import Array, Rows
from controller.errors import CommandRefused, RigUnreachable, TendrilError
from controller.schema.actuator import Actuator
from controller.schema.hardware import Drivers
from controller.schema.messages import RigInfo
from controller.schema.modes import Mode, Request
from controller.schema.parameters import RigParameters
from controller.schema.rig_file import RigFile
from controller.schema.states import LIVE
from server.access.permit import Permit, own
from server.commissioning.messages import Progress, StartBody, StepName
from server.commissioning.store import CommissioningStore
from server.log.events import words
from server.operate.asking import ask
from server.operate.borrowing import AGAIN, BLIND, POLL, Borrowing, Torques, stands_still
from server.operate.operator import Operator, Target
from server.operate.settings import KeptSettings
from server.presets.first_mode.store import FirstModes
from server.rig.client import Rig
from server.rig.history import Gathered, History
from server.rig.planner import Planner

READY = 5.0
"""For so long the rig may refuse to be armed [s]."""
RESTED = 30.0
"""Longest wait until the rig is vented [s]; it goes on to rest by itself."""


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
    modes: FirstModes
    """Of each actuator of the rig."""


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
    through: Through
    leave: Permit = field(init=False)
    """Of its requests."""
    borrowing: Borrowing = field(init=False)
    follows: bool = False
    """A row has shown FOLLOW: another mode ends it."""
    moves: bool = True
    """It has the rig, or waits for it; from then on it only computes, and nothing ends it but `stop`."""
    returning: bool = False
    """They are being put back."""
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
        operator = self.through.operator
        self.borrowing = Borrowing(operator, self.through.kept, self.leave, operator.settings)

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


class Motion:
    """What a step may do with the rig."""

    def __init__(self, through: Through, store: CommissioningStore, run: Run) -> None:
        self._through, self._store, self._run = through, store, run

    async def begin(self, **settings: Any) -> None:
        """Arm and follow under `settings` in place of the operator's: open loop without sensors where they leave it."""
        require_vented(self._through)
        run = self._run
        try:
            await asyncio.to_thread(self._store.borrow, run.borrowing.before)
        except OSError as error:
            raise CommandRefused(f"the settings cannot be kept meanwhile: {error.strerror}") from error
        await run.borrowing.put(lasting=True, **BLIND | settings)  # a server that starts anew must not close the loop
        held = await self._arm()
        await self._ask(Request.FOLLOW, (float(held["p_ref"][0]), float(held["p_ref"][1])))
        run.follows = True

    async def torque(self, u: Torques) -> None:
        """Let the open loop go to `u` [N m], at `torque_rate_max`."""
        await self._run.borrowing.torque(u)

    async def lead(self, begin: Torques, end: Torques, enough: Callable[[], bool] = lambda: False) -> None:
        """From one pair of torques to another as slowly as the rig comes to rest, or until it is `enough`."""
        await self._run.borrowing.lead(begin, end, self._run.parameters.controller.rest_rate, enough)

    async def target(self, at: Target) -> None:
        """Move the live target [m]."""
        reply = await asyncio.wrap_future(self._through.operator.move(at, self._run.leave))
        if not reply.accepted:
            raise CommandRefused(reply.detail)

    async def still(self, shortest: float, longest: float, swing: float) -> bool:
        """Wait until the tip swings by less than `swing` (rms) [m]; False where it does not within `longest` [s]."""
        return await stands_still(self._through.rig, self._through.history, swing, shortest, longest)

    def row(self) -> np.void:
        """The newest one."""
        return newest(self._through)

    def now(self) -> float:
        """Clock of the rig [s]."""
        return float(self.row()["t_ns"]) * 1e-9

    def slot(self) -> int:
        """Of the newest row, on the loop's grid."""
        return int(self.row()["slot"])

    def late(self, seconds: float) -> Rows:
        """The rows of the last `seconds`."""
        now = self.now()
        return self.between(now - seconds, now)

    def between(self, begin: float, end: float) -> Rows:
        """Rows from `begin` to `end` on the rig's clock [s]; CommandRefused where they are lost."""
        rows = self._through.history.rows(begin, end)
        if rows is None or not len(rows):
            raise CommandRefused("telemetry of this step was lost")
        return rows

    def gather(self, *names: str) -> Gathered:
        """These fields of all rows from now on: to be taken at least every few seconds, as the rig moves on."""
        return Gathered(self._through.history, self.now(), names)

    def tip(self, seconds: float) -> Array:
        """Where it was of late, on average (2,) [m]; CommandRefused where its marker is not seen."""
        rows = self.late(seconds)
        seen = np.isfinite(rows["p_meas"]).all(axis=1)
        if not seen.any():
            raise CommandRefused("the tip's marker is not seen: is the frame right, and does rod 10 bear a marker?")
        found: Array = rows["p_meas"][seen].mean(axis=0)
        return found

    def pressures(self, seconds: float) -> Array:
        """Mean measured pressures of late (4,) [Pa]."""
        found: Array = self.late(seconds)["pressure_meas"].mean(axis=0)
        return found

    async def end(self) -> None:
        """Come to rest, vent, and put the operator's settings back; whatever has become of the step."""
        run, through = self._run, self._through
        run.follows = False
        if run.borrowing.ours is None:
            return
        run.returning = True
        await rest(through, run.info.boot, run.leave)
        await put_back(run.borrowing, self._store)
        run.returning = False

    async def _arm(self) -> np.void:
        """Arm; after a new start of the rig its devices need a moment."""
        loop = asyncio.get_running_loop()
        end = loop.time() + READY
        while True:
            try:
                return await self._ask(Request.ARM)
            except CommandRefused:
                if loop.time() > end:
                    raise
            await asyncio.sleep(AGAIN / 2)

    async def _ask(self, request: Request, target: Target | None = None) -> np.void:
        return await ask(self._through.rig, self._through.operator, request, self._run.leave, target)


def newest(through: Through) -> np.void:
    """The rig's newest row; RigUnreachable without one."""
    found = through.rig.newest
    if found is None or through.rig.boot() is None:
        raise RigUnreachable("the rig does not answer")
    row: np.void = found[0]
    return row


def require_vented(through: Through) -> None:
    """Raise CommandRefused unless the rig is VENTED and its time goes on."""
    if through.rig.paused:
        raise CommandRefused("the twin is paused; continue it first")
    if (mode := Mode(int(newest(through)["mode"]))) != Mode.VENTED:
        raise CommandRefused(f"this step begins with the rig vented, and it is in {words(mode)}: let it rest first")


async def rest(through: Through, boot: int, leave: Permit) -> None:
    """Let what was armed come to rest and vent; one that was stopped or restarted has done so itself."""
    loop = asyncio.get_running_loop()
    end, again = loop.time() + RESTED, 0.0
    while loop.time() < end and through.rig.boot() == boot and (row := through.rig.newest) is not None:
        mode = Mode(int(row[0]["mode"]))
        if mode not in (*LIVE, Mode.REST):
            return
        if mode in LIVE and loop.time() > again:
            again = loop.time() + AGAIN
            with contextlib.suppress(TendrilError):
                permit = leave if leave.stands() else own()
                await asyncio.wrap_future(through.operator.request(Request.REST, permit))
        await asyncio.sleep(POLL)


async def put_back(borrowing: Borrowing, store: CommissioningStore) -> None:
    """Give back what was borrowed, and forget that it was."""
    await borrowing.give_back()
    with contextlib.suppress(OSError):  # it is tried again at the next start
        await asyncio.to_thread(store.borrow, None)
