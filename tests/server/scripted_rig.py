"""A rig, its link and its operator's thread as `Tracker` sees them, by the rig's own transition table.

It stands in for the real ones where hours of losses, stalls, refusals and restarts are tried in seconds: a test says
what goes wrong next. Every 20 ms of the event loop's clock it ticks twenty times and delivers its rows.
"""

import asyncio
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from types import SimpleNamespace
from typing import Any, Literal

import numpy as np

from controller.arrays import Rows
from controller.errors import RigUnreachable, TendrilError
from controller.link import PlannedRows
from controller.schema.layout import record_dtype
from controller.schema.messages import CommandReply, Telemetry
from controller.schema.modes import Cause, Mode, Request, refused_text
from controller.schema.parameters import RigParameters, Settings
from controller.schema.states import MOVING, next_mode
from server.access.permit import Permit
from server.operate.operator import Hears, Target

PERIOD_S, BATCH = 0.02, 20
SERVER_HOLD = 0.5
KEPT = 30.0
"""What the ring holds [s]: rows of a longer cut are lost."""
ANSWER = 0.5


Fate = Literal["dropped", "taken, its answer lost", "refused", "stalled"]
"""Stalled: the loop stood still before it took the request, which it left for HOLD within the tick."""


class ScriptedRig:
    """`rig` and `operator` of a Tracker."""

    def __init__(self, deliver: Callable[[Rows], None], clock: Callable[[], float]) -> None:
        self._deliver, self._clock = deliver, clock
        self.settings, self.parameters = Settings(), RigParameters()
        self.trouble, self.paused = "", False
        self.boot_id = 0
        self.newest: Rows | None = None
        self.cut = self.deaf = False
        """No row and no answer comes; what is asked does not arrive."""
        self.next: dict[Request, Fate] = {}
        """What becomes of the next request of a kind."""
        self._asked: deque[tuple[Request, Permit, Future[CommandReply]]] = deque()
        self._heard = 0.0
        self._hears: list[Hears] = []
        self.restart()
        self.mode, self.cause = Mode.HOLD, Cause.OPERATOR

    @property
    def info(self) -> Any:
        return SimpleNamespace(boot=self.known_boot, parameters=self.parameters, controllers=())

    @property
    def age(self) -> float:
        return self._clock() - self._heard

    def require_info(self) -> Any:
        return self.info

    def boot(self) -> int | None:
        return self.known_boot if self.age < 0.6 else None

    def plan(self, rows: PlannedRows, permit: Permit) -> None:
        permit.require()
        if self.cut or self.deaf:
            raise RigUnreachable("the rig did not answer within 5 s")
        assert rows.ticks is not None
        self.ticks, self.planned = rows.ticks, True

    def listen(self, hears: Hears) -> None:
        self._hears.append(hears)

    def request(self, request: Request, permit: Permit, target: Target | None = None) -> "Future[CommandReply]":
        if request != Request.NONE or target is not None:
            for hears in self._hears:
                hears(request, None if request == Request.E_STOP else permit)
        asker: Future[CommandReply] = Future()
        asker.set_running_or_notify_cancel()
        self._asked.append((request, permit, asker))
        return asker

    def restart(self) -> None:
        self.boot_id += 1
        self.mode, self.cause = Mode.VENTED, Cause.START
        self.tick = self.request_n = self.tracked = self.ticks = 0
        self.request_cause, self.planned = Cause.NONE, False
        self._unsent: list[Rows] = []
        self._silent = 0.0

    def move(self, mode: Mode, cause: Cause) -> None:
        """Let the rig go there by itself."""
        self.mode, self.cause = mode, cause

    async def run(self) -> None:
        """Tick until cancelled."""
        loop = asyncio.get_running_loop()
        self.known_boot, self._heard = self.boot_id, loop.time()
        while True:
            await asyncio.sleep(PERIOD_S)
            self._serve(loop)
            self._tick()
            if not self.cut:
                self._send(loop.time())

    def _serve(self, loop: asyncio.AbstractEventLoop) -> None:
        """One request a batch, as the operator's thread has them."""
        self._silent = self._silent + PERIOD_S if self.cut and self.deaf else 0.0
        if self._silent > SERVER_HOLD and self.mode in MOVING:
            self.move(Mode.HOLD, Cause.SERVER_LOST)
        if not self._asked:
            return
        request, permit, asker = self._asked.popleft()
        try:
            permit.require(request)
        except TendrilError as error:
            return asker.set_exception(error)
        fate = self.next.pop(request, None)
        if self.deaf or fate == "dropped":
            return self._fail(loop, asker)
        reply = self._answer(request, fate)
        if self.cut or fate == "taken, its answer lost":
            return self._fail(loop, asker)
        asker.set_result(reply)

    def _fail(self, loop: asyncio.AbstractEventLoop, asker: "Future[CommandReply]") -> None:
        error: TendrilError = RigUnreachable("the rig did not answer within 0.5 s")
        loop.call_later(ANSWER, asker.set_exception, error)

    def _answer(self, request: Request, fate: Fate | None) -> CommandReply:
        if request == Request.NONE:
            return CommandReply(n=self.request_n, accepted=True, mode=self.mode, cause=self.cause, detail="")
        self.request_n += 1
        wanted = next_mode(self.mode, request)
        refusal = Cause.NONE if wanted is not None else Cause.WRONG_MODE
        if request == Request.TRACK and not self.planned:
            refusal = Cause.NO_REFERENCE
        if fate == "refused":
            refusal = Cause.NO_OPERATOR
        self.request_cause = refusal
        if refusal == Cause.NONE and wanted is not None:
            self.move(wanted, Cause.OPERATOR)
            self.tracked = 0
            if fate == "stalled" and self.mode in MOVING:
                self.move(Mode.HOLD, Cause.LOOP_STALLED)
        text = "" if refusal == Cause.NONE else refused_text(request, self.mode, refusal)
        n, accepted = self.request_n, refusal == Cause.NONE
        return CommandReply(n=n, accepted=accepted, mode=self.mode, cause=self.cause, detail=text)

    def _tick(self) -> None:
        rows = np.zeros(BATCH, record_dtype(Telemetry))
        rows["tick"] = rows["slot"] = self.tick + np.arange(BATCH)
        rows["t_ns"] = rows["tick"] * 1_000_000
        rows["mode"], rows["cause"] = self.mode, self.cause
        rows["request_n"] = rows["command_n"] = self.request_n
        rows["request_cause"] = self.request_cause
        self.tick += BATCH
        if self.mode == Mode.TRACK and (self.tracked + BATCH >= self.ticks):
            self.move(Mode.HOLD, Cause.REFERENCE_DONE)
            rows["mode"][self.ticks - self.tracked :] = self.mode
            rows["cause"][self.ticks - self.tracked :] = self.cause
        self.tracked += BATCH
        self._unsent.append(rows)
        del self._unsent[: -round(KEPT / PERIOD_S)]

    def _send(self, now: float) -> None:
        if self.boot_id != self.known_boot:
            self.known_boot, self.newest = self.boot_id, None
        rows = self._unsent[0] if len(self._unsent) == 1 else np.concatenate(self._unsent)
        self._unsent.clear()
        self.newest, self._heard = rows[-1:], now
        self._deliver(rows)
