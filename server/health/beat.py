"""The server's beat: whenever rows come everything is looked at, with or without viewers, each look for itself."""

import asyncio
import time
from collections.abc import Sequence
from contextlib import suppress

from controller.arrays import Rows
from controller.system.looks import Looks, Watcher

SHORTEST, LONGEST = 0.014, 0.02
"""From one look at everything to the next [s]: the rig sends 60 batches a second, and may be silent."""


class Beat:
    """Calls the watchers in their order; one that fails ends no other."""

    def __init__(self, looks: Looks, watchers: Sequence[Watcher]) -> None:
        self._looks, self._watchers = looks, watchers
        self._beaten = time.monotonic()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._due = asyncio.Event()

    @property
    def age(self) -> float:
        """Time since the last beat [s]."""
        return time.monotonic() - self._beaten

    def rows(self, rows: Rows) -> None:
        """Rows have come; from the link's thread."""
        if self._loop is not None:
            with suppress(RuntimeError):  # the loop is closed: the server ends
                self._loop.call_soon_threadsafe(self._due.set)

    async def run(self) -> None:
        """Beat until cancelled."""
        self._loop = asyncio.get_running_loop()
        while True:
            await self._next(self._loop)
            for watcher in self._watchers:
                self._looks.do(watcher.watched, watcher.look)
            self._beaten = time.monotonic()

    async def _next(self, loop: asyncio.AbstractEventLoop) -> None:
        """Wait for rows, within bounds."""
        timer = loop.call_later(self._beaten + LONGEST - time.monotonic(), self._due.set)
        try:
            await self._due.wait()
        finally:
            timer.cancel()
        await asyncio.sleep(max(0.0, self._beaten + SHORTEST - time.monotonic()))
        self._due.clear()
