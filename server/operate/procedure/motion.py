"""What a procedure does with the rig: it asks, leads the open loop, waits, and reads what telemetry shows."""

import asyncio
from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np

from controller.arrays import Array, Rows
from controller.errors import CommandRefused, RigUnreachable
from controller.schema.messages import RigInfo
from controller.schema.modes import Mode, Request
from server.access.permit import Permit
from server.log.events import EventLog
from server.operate.operator import Operator, Target
from server.operate.procedure.override import OverrideNote, SettingsOverride
from server.operate.settings import KeptSettings
from server.rig.client import Rig
from server.rig.history import Gathered, History

ROW_POLL_S = 5e-3
"""Between two looks at the telemetry."""
ROW_MAX_S = 5.0
"""Longest wait for a row that shows what was asked for."""
POLL_S = 0.05
"""Between two looks at what moves, and between two torques on the way."""
STILL_WINDOW_S = 0.4
"""Over which the tip must stand still."""
Torques = tuple[float, float]


@dataclass(frozen=True)
class Context:
    """What procedures work with. `note`: where a lasting override is noted."""

    rig: Rig
    history: History
    operator: Operator
    kept: KeptSettings
    events: EventLog
    note: OverrideNote | None = None


async def ask(rig: Rig, operator: Operator, request: Request, permit: Permit, target: Target | None = None) -> np.void:
    """Ask the rig; the first row that came of it. CommandRefused where it does not do it, RigUnreachable without."""
    reply = await asyncio.wrap_future(operator.request(request, permit, target))
    if not reply.accepted:
        raise CommandRefused(reply.detail)
    return await shown(rig, reply.n, ROW_MAX_S)


async def shown(rig: Rig, n: int, seconds_max: float) -> np.void:
    """The first row that came of command number `n`; RigUnreachable where none does within `seconds_max`."""
    loop = asyncio.get_running_loop()
    end = loop.time() + seconds_max
    while (newest := rig.newest) is None or newest[0]["command_n"] < n:
        if loop.time() > end:
            raise RigUnreachable("the rig does not answer")
        await asyncio.sleep(ROW_POLL_S)
    row: np.void = newest[0]
    return row


def newest_row(rig: Rig) -> np.void:
    """The rig's newest row; RigUnreachable where it does not answer."""
    if (found := rig.newest) is None or rig.boot() is None:
        raise RigUnreachable("the rig does not answer")
    row: np.void = found[0]
    return row


def require_mode(rig: Rig, modes: Collection[Mode], refusal: Callable[[Mode], str]) -> np.void:
    """The rig's newest row; CommandRefused unless its time goes on and it is in one of `modes`, RigUnreachable."""
    row = newest_row(rig)
    if rig.paused:
        raise CommandRefused("the twin is paused; continue it first")
    if (mode := Mode(int(row["mode"]))) not in modes:
        raise CommandRefused(refusal(mode))
    return row


class Motion:
    """The rig under one permit, from the boot `info` on."""

    def __init__(self, context: Context, info: RigInfo, permit: Permit, lasting: bool = False) -> None:
        self.context, self.info, self.permit = context, info, permit
        note = context.note if lasting else None
        self.override = SettingsOverride(context.operator, context.kept, permit, note)
        self.follows = False
        """A row has shown FOLLOW: another mode ends it."""

    async def ask(self, request: Request, target: Target | None = None) -> np.void:
        """The first row that came of it; CommandRefused, RigUnreachable."""
        return await ask(self.context.rig, self.context.operator, request, self.permit, target)

    async def follow(self, held: np.void) -> None:
        """FOLLOW at the reference of this row."""
        await self.ask(Request.FOLLOW, (float(held["p_ref"][0]), float(held["p_ref"][1])))
        self.follows = True

    async def target(self, at: Target) -> None:
        """Move the live target [m]."""
        reply = await asyncio.wrap_future(self.context.operator.move(at, self.permit))
        if not reply.accepted:
            raise CommandRefused(reply.detail)

    async def torque(self, u: Torques) -> None:
        """Let the open loop go to `u` [N m], at `torque_rate_max`; CommandRefused where the settings are not ours."""
        if self.override.ours is None:
            raise CommandRefused("the settings were changed")
        await self.override.put(u_open=u)

    async def lead(self, begin: Torques, end: Torques, enough: Callable[[], bool] = lambda: False) -> None:
        """From one pair of torques to another as slowly as the rig comes to rest, or until it is `enough`."""
        way = max(abs(b - a) for a, b in zip(begin, end, strict=True))
        steps = max(1, int(way / (self.info.parameters.controller.rest_rate * POLL_S)))
        for u in np.linspace(begin, end, steps + 1)[1:]:
            await self.torque((float(u[0]), float(u[1])))
            await asyncio.sleep(POLL_S)
            if enough():
                return

    async def still(self, seconds_min: float, seconds_max: float, swing: float) -> bool:
        """Wait until the tip swings by less than `swing` (rms) [m]; False where it does not within `seconds_max`.

        A tip that is not seen does not stand still.
        """
        loop = asyncio.get_running_loop()
        begin = loop.time()
        while (passed := loop.time() - begin) < seconds_max:
            if passed > seconds_min and self.context.rig.newest is not None:
                now = self.now()
                rows = self.context.history.rows(now - STILL_WINDOW_S, now)
                if rows is not None and len(rows) and np.linalg.norm(rows["p_meas"].std(axis=0)) < swing:  # not of nan
                    return True
            await asyncio.sleep(POLL_S)
        return False

    def row(self) -> np.void:
        """The newest one; RigUnreachable without."""
        return newest_row(self.context.rig)

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
        rows = self.context.history.rows(begin, end)
        if rows is None or not len(rows):
            raise CommandRefused("telemetry of this step was lost")
        return rows

    def gather(self, *names: str) -> Gathered:
        """These fields of all rows from now on: to be taken at least every few seconds, as the rig moves on."""
        return Gathered(self.context.history, self.now(), names)

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
