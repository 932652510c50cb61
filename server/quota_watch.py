"""Old recordings go when all together take too much; the log says which."""

import asyncio
import time

from recordings.quota import default_quota, enforce, too_large
from recordings.store import Store
from server.events import EventLog

PERIOD = 60.0
"""Between two looks [s]: a minute of a recording is 35 MB at most."""


class QuotaWatch:
    """Called at every beat; looks once a minute, off the event loop."""

    def __init__(self, store: Store, most: int | None, events: EventLog) -> None:
        self._store, self._events = store, events
        self._most = default_quota(store.folder) if most is None else most
        self._due, self._told = 0.0, ""
        self._task: asyncio.Task[None] | None = None

    def __call__(self) -> None:
        """Look, if it is time."""
        if time.monotonic() >= self._due and (self._task is None or self._task.done()):
            self._due = time.monotonic() + PERIOD
            self._task = asyncio.create_task(self.look())

    async def look(self) -> None:
        """Remove what is too much, and say what cannot be removed."""
        try:
            for gone in await asyncio.to_thread(enforce, self._store, self._most):
                self._events.add(f"recording {gone.id} was removed, the oldest: {self._bound}", "warning")
            large = await asyncio.to_thread(too_large, self._store, self._most)
            if large and large.id != self._told:
                self._told = large.id
                alone = f"recording {large.id} alone takes {large.bytes / 1e9:.3g} GB"
                self._events.add(f"{alone}, and {self._bound}: it stays until a newer one ends", "warning")
        except OSError as error:
            self._events.add(f"old recordings cannot be removed: {error}", "warning")

    @property
    def _bound(self) -> str:
        return f"all together may take {self._most / 1e9:.3g} GB (TENDRIL_RECORDINGS_QUOTA)"
