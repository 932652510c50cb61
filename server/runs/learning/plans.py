"""Plans of runs, as far as their paths are learned: what the run asks the planner's process for."""

import asyncio
import logging
from pathlib import Path
from typing import Annotated

from controller.arrays import Array
from controller.errors import TendrilError
from controller.schema.parameters import RigParameters, Settings
from server.http.given import given
from server.log.events import EventLog
from server.rig.planner import Planner
from server.runs import planning
from server.runs.lap import Lap, Leg, Order, Place
from server.runs.learning.seen import Repeat
from server.runs.messages import RunBody

log = logging.getLogger(__name__)


class Plans:
    """The next plan waits until what was followed before is learned from; nobody else does."""

    def __init__(self, planner: Planner, lessons: Path, events: EventLog) -> None:
        """`lessons`: folder of what is learned of paths."""
        self._planner, self._lessons, self._events = planner, lessons, events
        self._learning: asyncio.Task[None] | None = None

    async def lap(self, body: RunBody, rig: RigParameters, settings: Settings) -> Lap:
        """As `planning.lap`."""
        return await self._planner.do(planning.lap, body, rig, settings)

    async def leg(self, order: Order, u: Array, left: Place | None = None) -> Leg:
        """As `planning.leg`."""
        await self._learned()
        return await self._planner.do(planning.leg, order, self._lessons, u, left)

    def teach(self, order: Order, repeat: Repeat) -> None:
        """Learn from a repeat that has ended, beside everything else."""
        self._learning = asyncio.ensure_future(self._teach(order, repeat))

    async def forget(self, key: str) -> bool:
        """Whether something was learned of a path, which is forgotten now. Raises OSError."""
        await self._learned()
        return await self._planner.do(planning.forget, self._lessons, key)

    async def _learned(self) -> None:
        if self._learning is not None:
            await asyncio.shield(self._learning)

    async def _teach(self, order: Order, repeat: Repeat) -> None:
        try:
            await self._planner.do(planning.teach, order, self._lessons, repeat)
        except (OSError, TendrilError) as error:
            self._events.add(f"what a repeat of {order.lap.name} taught is lost: {error}", "warning")
        except Exception:
            log.exception("a repeat taught nothing")
            self._events.add(f"what a repeat of {order.lap.name} taught is lost", "warning")


GivenPlans = Annotated[Plans, given(Plans)]
