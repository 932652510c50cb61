"""What a run asks of the rig: to hold, to take rows, to track them."""

import asyncio
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from controller.arrays import Array, Rows
from controller.errors import CommandRefused, RigUnreachable
from controller.link import PlannedRows
from controller.schema.messages import RigInfo
from controller.schema.modes import Cause, Law, Mode, Request, refused_text
from controller.schema.parameters import Settings
from controller.schema.states import LIVE
from server.access.permit import Permit, own
from server.operate.operator import Operator
from server.operate.procedure.motion import require_mode, shown
from server.rig.client import Rig
from server.runs.lap import Leg
from server.runs.run import Before

ROW_MAX_S = 1.0
"""Longest wait for a row after the rig's answer."""
ANSWER_MAX_S = 5.0
"""The same for the answer: it may wait behind others, each of which the link ends after a second at most."""
REST_TORQUE_MAX = 1e-3
"""Less torque than this is none [N m]."""


@dataclass(frozen=True)
class Held:
    """The rig in HOLD, as a row shows it."""

    u: Array
    """The feedforward's torques (2,) [N m]."""
    before: Before


class Tracker:
    """The rig's end of a run. What it refuses is a CommandRefused with its reason."""

    def __init__(self, rig: Rig, operator: Operator) -> None:
        self._rig, self._operator = rig, operator
        # Threads of its own: those of the event loop may all wait for a disk that hangs.
        self._threads = ThreadPoolExecutor(2, thread_name_prefix="upload")

    def require_ready(self) -> RigInfo:
        """Who the rig is; raises unless it could track a reference now, after a HOLD."""
        require_mode(self._rig, LIVE, lambda mode: refused_text(Request.TRACK, mode, Cause.WRONG_MODE))
        if self._operator.settings.law == Law.OPEN_LOOP:
            raise CommandRefused("in open loop no reference is followed; choose a law with feedforward")
        return self._rig.require_info()

    @property
    def settings(self) -> Settings:
        """The settings in force."""
        return self._operator.settings

    async def hold(self, permit: Permit) -> Held:
        """Let the rig hold, and wait for the row that shows it."""
        newest = await shown(self._rig, await self.halt(permit), ROW_MAX_S)
        if newest["mode"] != Mode.HOLD:
            raise CommandRefused(refused_text(Request.TRACK, Mode(int(newest["mode"])), Cause.WRONG_MODE))
        return Held(newest["u_ff"].copy(), Before(int(newest["tick"]), int(newest["request_n"])))

    async def halt(self, permit: Permit) -> int:
        """Let the rig hold; the number of the command that it took."""
        return await self._request(Request.HOLD, permit)

    async def upload(self, leg: Leg, permit: Permit) -> None:
        """Give the rig the rows of `leg`."""
        rows = PlannedRows(leg.p, leg.u, leg.kinds, leg.again, leg.ticks, leg.planned, leg.planned_again, leg.steps)
        await asyncio.get_running_loop().run_in_executor(self._threads, self._rig.plan, rows, permit)

    async def track(self, permit: Permit) -> None:
        """Let the rig follow what was uploaded last."""
        await self._request(Request.TRACK, permit)

    def let_hold(self) -> None:
        """Let the rig hold, and wait for no answer: its rows tell."""
        self._operator.request(Request.HOLD, own())

    async def _request(self, request: Request, permit: Permit) -> int:
        """The number of the command that the rig took."""
        asked = asyncio.wrap_future(self._operator.request(request, permit))
        try:
            reply = await asyncio.wait_for(asked, ANSWER_MAX_S)
        except TimeoutError as error:
            raise RigUnreachable(f"{request.name} was not answered within {ANSWER_MAX_S:g} s") from error
        if not reply.accepted:
            raise CommandRefused(reply.detail)
        return reply.n


def standing(newest: Rows | None) -> Array:
    """Torques (2,) [N m] of the feedforward in this row (1,), where the rig holds or moves; else 0, at rest."""
    if newest is None or newest["mode"][0] not in LIVE or np.abs(newest["u_ff"]).max() < REST_TORQUE_MAX:
        return np.zeros(2)
    found: Array = newest["u_ff"][0].astype(np.float64)
    return found
