"""Runs foreseen for the page."""

import asyncio
import uuid
from collections.abc import AsyncGenerator
from contextlib import suppress
from typing import Annotated

from controller.arrays import Array
from controller.errors import TendrilError
from controller.schema.parameters import RigParameters, Settings
from server.http.given import given
from server.rig.planner import Planner
from server.runs import planning
from server.runs.messages import Preview, PreviewBody, PreviewPart


class Previews:
    """One preview at a time: each keeps a core busy."""

    def __init__(self, planner: Planner) -> None:
        self._planner, self._turn = planner, asyncio.Lock()

    async def of(self, body: PreviewBody, rig: RigParameters, settings: Settings, u: Array) -> Preview:
        """As `planning.preview` foresees it."""
        async with self._turn:
            return await self._planner.do(planning.preview, body, rig, settings, u)

    async def parts(
        self, body: PreviewBody, rig: RigParameters, settings: Settings, u: Array
    ) -> AsyncGenerator[PreviewPart, None]:
        """The same piece by piece, for who wants to see it come. Errors before the first piece as above."""
        key, foreseen = uuid.uuid4().hex, (body, rig, settings, u)
        try:
            async with self._turn:
                part = await self._planner.do(planning.begin_preview, key, *foreseen)
            yield part
            while part.preview is None:
                async with self._turn:
                    more = await self._planner.do(planning.go_on_with_preview, key)
                    if more is None:  # another planner: the one that began it was killed
                        more = await self._planner.do(planning.begin_preview, key, *foreseen)
                part = more
                yield part
        finally:
            asyncio.get_running_loop().run_in_executor(None, self._drop, key)

    def _drop(self, key: str) -> None:
        with suppress(TendrilError):  # a planner that has ended knows it no more
            self._planner.call(planning.drop_preview, key)


GivenPreviews = Annotated[Previews, given(Previews)]
