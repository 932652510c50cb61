"""Settings that a measurement puts in force for a while: an open loop that it leads, and what it gives back.

What was borrowed is given back whatever ends the measurement, but for what somebody else has changed meanwhile.
"""

import asyncio
import contextlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from controller.errors import CommandRefused, TendrilError
from controller.schema.modes import Law, Request
from controller.schema.parameters import Settings
from server.access.permit import Permit
from server.operate.operator import Operator
from server.operate.settings import KeptSettings, put_in_force
from server.rig.client import Rig
from server.rig.history import History

POLL = 0.05
"""Between two looks at the rig, and between two torques on the way [s]."""
AGAIN = 1.0
"""Between two tries to give the settings back [s]."""
WINDOW = 0.4
"""Over which the tip must stand still [s]."""
BLIND = {"law": Law.OPEN_LOOP, "u_open": (0.0, 0.0), "sensed": 0}
"""An open loop without sensors."""
Torques = tuple[float, float]


@dataclass
class Borrowing:
    """Settings of the operator, borrowed; only the event loop uses it."""

    operator: Operator
    kept: KeptSettings
    leave: Permit
    """Of what it asks for."""
    before: Settings
    """What is to be given back."""
    ours: Settings | None = None
    """What it has asked for last; None: nothing is borrowed."""

    @property
    def changed(self) -> bool:
        """Whether somebody else has changed the settings meanwhile."""
        return self.ours is not None and not self.kept.changing.locked() and self.operator.settings != self.ours

    async def put(self, lasting: bool = False, **changes: object) -> None:
        """Put the settings with `changes` in force, CommandRefused where others changed them or the rig refuses.

        `lasting`: a server that starts anew begins with them, too.
        """
        async with self.kept.changing:
            if self.ours is not None and self.operator.settings != self.ours:
                raise CommandRefused("the settings were changed")
            self.ours = self.operator.settings.model_copy(update=changes)
            await put_in_force(self.ours, self.operator, self.leave)
            if lasting:
                await self.kept.keep(self.ours)

    async def torque(self, u: Torques) -> None:
        """Let the open loop go to `u` [N m], at `torque_rate_max`; CommandRefused as by `put`, or if none is lent."""
        if self.ours is None:
            raise CommandRefused("the settings were changed")
        await self.put(u_open=u)

    async def lead(self, begin: Torques, end: Torques, rate: float, enough: Callable[[], bool] = lambda: False) -> None:
        """Let the open loop go from one pair of torques to another at `rate` [N m/s], or until it is `enough`."""
        steps = max(1, int(max(abs(b - a) for a, b in zip(begin, end, strict=True)) / (rate * POLL)))
        for u in np.linspace(begin, end, steps + 1)[1:]:
            await self.torque((float(u[0]), float(u[1])))
            await asyncio.sleep(POLL)
            if enough():
                return

    async def give_back(self, names: Iterable[str] = Settings.model_fields) -> None:
        """Give these of the settings back, but for those that differ from ours; until the rig takes them."""
        while (ours := self.ours) is not None:
            async with self.kept.changing:
                found = self.operator.settings
                lent = [name for name in names if getattr(found, name) == getattr(ours, name)]
                given_back = found.model_copy(update={name: getattr(self.before, name) for name in lent})
                with contextlib.suppress(TendrilError):
                    await put_in_force(given_back, self.operator, _giving_back())
                    await self.kept.keep(self.operator.settings)
                    self.ours = None
            if self.ours is not None:
                await asyncio.sleep(AGAIN)


def _giving_back() -> Permit:
    """For the settings that were found; it covers no request."""
    return Permit(None, lambda request: "", frozenset({Request.NONE}))


async def stands_still(rig: Rig, history: History, swing: float, shortest: float, longest: float) -> bool:
    """Wait until the tip swings by less than `swing` (rms) [m] over WINDOW; False where it does not in `longest` [s].

    It is given `shortest` [s] at least. A tip that is not seen does not stand still.
    """
    loop = asyncio.get_running_loop()
    begin = loop.time()
    while (passed := loop.time() - begin) < longest:
        if passed > shortest and rig.newest is not None:
            now = float(rig.newest[0]["t_ns"]) * 1e-9
            rows = history.rows(now - WINDOW, now)
            if rows is not None and len(rows) and np.linalg.norm(rows["p_meas"].std(axis=0)) < swing:  # not of nan
                return True
        await asyncio.sleep(POLL)
    return False
