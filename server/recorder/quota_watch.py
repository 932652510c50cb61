"""Old recordings go when all together take too much; the log says which."""

import asyncio

from controller.system.scheduler import Scheduler
from recordings.store.quota import default_quota, enforce, too_large
from recordings.store.store import Store
from server.log.events import EventLog

QUOTA_S = 60.0
"""Between two looks: a minute of a recording is 35 MB at most."""


class QuotaWatch:
    """Looks once a minute, off the event loop."""

    def __init__(self, store: Store, most: int | None, events: EventLog, scheduler: Scheduler) -> None:
        self._store, self._events = store, events
        self._given = most
        self._told = self._problem = ""
        self._scheduler = scheduler
        self._busy = False

    def look(self) -> None:
        """A job: look, unless the last look is still under way."""
        if not self._busy:
            self._busy = True
            self._scheduler.begin("the look at the recordings' size", self.keep())

    async def keep(self) -> None:
        """Remove what is too much, and say once what cannot be removed, or that no one can look."""
        try:
            most = await asyncio.to_thread(self._most)
            if most is None:
                await asyncio.to_thread(self._store.list)  # which notes why no one can look
            else:
                await self._enforce(most)
            problem = self._store.problem
        except OSError as error:
            problem = f"old recordings cannot be removed: {error}"
        finally:
            self._busy = False
        if problem and problem != self._problem:
            self._events.add(problem, "warning")
        self._problem = problem

    async def _enforce(self, most: int) -> None:
        bound = f"all together may take {most / 1e9:.3g} GB (TENDRIL_RECORDINGS_QUOTA)"
        for gone in await asyncio.to_thread(enforce, self._store, most):
            self._events.add(f"recording {gone.id} was removed, the oldest: {bound}", "warning")
        large = await asyncio.to_thread(too_large, self._store, most)
        if large and large.id != self._told:
            self._told = large.id
            alone = f"recording {large.id} alone takes {large.bytes / 1e9:.3g} GB"
            self._events.add(f"{alone}, and {bound}: it stays until a newer one ends", "warning")

    def _most(self) -> int | None:
        """As given; else by the disk, which is there once there is a recording; None without it."""
        if self._given is not None:
            return self._given
        try:
            return default_quota(self._store.folder)
        except FileNotFoundError:
            return None
