"""What a run asks of the rig: to hold, to take rows, to track them."""

import asyncio
import time

import numpy as np

from controller.errors import CommandRefused, RigUnreachable
from controller.kernels.rod import Array
from controller.messages import RigInfo
from controller.modes import Cause, Law, Mode, Request
from controller.parameters import Settings
from controller.realtime.desk import refused_text
from server.channels import Rows
from server.operator import Operator
from server.rig import Rig

POLL = 5e-3
"""Pause between two looks at the telemetry [s]."""
PATIENCE = 1.0
"""Longest wait for a row after the rig's answer [s]."""
LIVE = (Mode.HOLD, Mode.FOLLOW, Mode.TRACK)


class Tracker:
    """The rig's end of a run. What it refuses is a CommandRefused with its reason."""

    def __init__(self, rig: Rig, operator: Operator) -> None:
        self._rig, self._operator = rig, operator

    def require_ready(self) -> RigInfo:
        """Who the rig is; raises unless it could track a reference now, after a HOLD."""
        info, newest = self._rig.info, self._newest()
        if info is None or newest is None or self._rig.boot() is None:
            raise RigUnreachable("the rig does not answer")
        if (mode := Mode(int(newest["mode"]))) not in LIVE:
            raise CommandRefused(refused_text(Request.TRACK, mode, Cause.WRONG_MODE))
        if self._operator.settings.law == Law.OPEN_LOOP:
            raise CommandRefused("in open loop no reference is followed; choose a law with feedforward")
        return info

    @property
    def settings(self) -> Settings:
        """The settings in force."""
        return self._operator.settings

    def life(self) -> int | None:
        """The life of the rig whose rows came last."""
        return self._rig.info.boot if self._rig.info else None

    def age(self) -> float:
        """Time since the last telemetry [s]."""
        return self._rig.age

    async def hold(self) -> Array:
        """Let the rig hold; the feedforward's torques (2,) [N m] there."""
        n, end = await self._request(Request.HOLD), time.monotonic() + PATIENCE
        while (newest := self._newest()) is None or newest["command_n"] < n:
            if time.monotonic() > end:
                raise RigUnreachable("the rig does not answer")
            await asyncio.sleep(POLL)
        if newest["mode"] != Mode.HOLD:
            raise CommandRefused(refused_text(Request.TRACK, Mode(int(newest["mode"])), Cause.WRONG_MODE))
        found: Array = newest["u_ff"].copy()
        return found

    async def track(self, rows: Array, again: int, ticks: int) -> None:
        """Let the rig follow rows (n, 2) [m], of which row `again` comes after the last one, for so many ticks."""
        await asyncio.to_thread(self._rig.plan, rows, again, ticks)
        self._operator.present()
        await self._request(Request.TRACK)

    async def _request(self, request: Request) -> int:
        """The number of the command that the rig took."""
        reply = await asyncio.wrap_future(self._operator.request(request))
        if not reply.accepted:
            raise CommandRefused(reply.detail)
        return reply.n

    def _newest(self) -> np.void | None:
        newest: Rows | None = self._rig.newest
        return None if newest is None else newest[0]
