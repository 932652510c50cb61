"""Runs foreseen for the page."""

import asyncio
from typing import Annotated

from controller.arrays import Array
from controller.schema.parameters import RigParameters, Settings
from server.http.given import given
from server.rig.planner import Planner
from server.runs import planning
from server.runs.messages import Preview, PreviewBody


class Previews:
    """One preview at a time: each keeps a core busy."""

    def __init__(self, planner: Planner) -> None:
        self._planner, self._turn = planner, asyncio.Lock()

    async def of(self, body: PreviewBody, rig: RigParameters, settings: Settings, u: Array) -> Preview:
        """As `planning.preview` foresees it."""
        async with self._turn:
            return await self._planner.do(planning.preview, body, rig, settings, u)


GivenPreviews = Annotated[Previews, given(Previews)]
