"""The server's beat: 60 times a second everything is looked at, with or without viewers, each look for itself."""

import asyncio
import time
from collections.abc import Sequence

from controller.system.looks import Looks, Watcher

BEAT = 1 / 60
"""Seconds from one look at everything to the next."""


class Beat:
    """Calls the watchers in their order; one that fails ends no other."""

    def __init__(self, looks: Looks, watchers: Sequence[Watcher]) -> None:
        self._looks, self._watchers = looks, watchers
        self._beaten = time.monotonic()

    @property
    def age(self) -> float:
        """Time since the last beat [s]."""
        return time.monotonic() - self._beaten

    async def run(self) -> None:
        """Beat until cancelled."""
        due = time.monotonic()
        while True:
            due = max(due + BEAT, time.monotonic())
            await asyncio.sleep(due - time.monotonic())
            for watcher in self._watchers:
                self._looks.do(watcher.watched, watcher.look)
            self._beaten = time.monotonic()
