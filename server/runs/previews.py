"""Runs foreseen for the page."""

import asyncio
import uuid
from collections.abc import AsyncGenerator, Callable
from contextlib import suppress
from pathlib import Path
from typing import Annotated

from controller.arrays import Array
from controller.errors import TendrilError
from controller.schema.messages import RigInfo
from controller.schema.parameters import RigParameters, Settings
from server.http.given import given
from server.rig.planner import Planner
from server.runs import planning
from server.runs.messages import Preview, PreviewBody, PreviewPart

IDLE = 10.0
"""Who has not asked for the next part for so long makes room for others, and then begins again [s]."""


class Previews:
    """One preview at a time: each keeps a core busy. Of those that are told in parts as many as the planner keeps."""

    def __init__(
        self, planner: Planner, twin_of: Callable[[RigInfo], RigParameters], lessons: Path = planning.NOTHING
    ) -> None:
        """`twin_of` says what stands for a rig in what is foreseen, `lessons` is where what was learned is kept."""
        self._planner, self._twin_of, self._turn, self._lessons = planner, twin_of, asyncio.Lock(), lessons
        self._places = asyncio.Semaphore(planning.KEPT)

    async def of(self, body: PreviewBody, rig: RigInfo, settings: Settings, u: Array) -> Preview:
        """As `planning.preview` foresees it."""
        async with self._turn:
            return await self._planner.do(planning.preview, self._asked(body, rig, settings, u))

    def _asked(self, body: PreviewBody, rig: RigInfo, settings: Settings, u: Array) -> planning.Asked:
        return planning.Asked(body, self._twin_of(rig), settings, u, self._lessons)

    async def parts(
        self, body: PreviewBody, rig: RigInfo, settings: Settings, u: Array
    ) -> AsyncGenerator[PreviewPart, None]:
        """The same piece by piece, for who wants to see it come. Errors before the first piece as above."""
        key, asked, place = uuid.uuid4().hex, self._asked(body, rig, settings, u), _Place(self._places)
        try:
            await place.take()
            async with self._turn:
                part = await self._planner.do(planning.begin_preview, key, asked)
            place.lend()
            yield part
            while part.preview is None:
                await place.take()
                async with self._turn:
                    more = await self._planner.do(planning.go_on_with_preview, key)
                    if more is None:  # another planner, as the one that began it was killed; or it made room
                        more = await self._planner.do(planning.begin_preview, key, asked)
                part = more
                place.lend()
                yield part
        finally:
            place.leave()
            asyncio.get_running_loop().run_in_executor(None, self._drop, key)

    def _drop(self, key: str) -> None:
        with suppress(TendrilError):  # a planner that has ended knows it no more
            self._planner.call(planning.drop_preview, key)


class _Place:
    """One of the previews that the planner keeps."""

    def __init__(self, places: asyncio.Semaphore) -> None:
        self._places, self._held = places, False
        self._idle: asyncio.TimerHandle | None = None

    async def take(self) -> None:
        """Wait for a place, unless it is held still."""
        if self._idle is not None:
            self._idle.cancel()
        if not self._held:
            await self._places.acquire()
            self._held = True

    def lend(self) -> None:
        """Nothing is to be done until the next part is asked for."""
        self._idle = asyncio.get_running_loop().call_later(IDLE, self.leave)

    def leave(self) -> None:
        """Others may have it."""
        if self._idle is not None:
            self._idle.cancel()
        if self._held:
            self._held = False
            self._places.release()


GivenPreviews = Annotated[Previews, given(Previews)]
