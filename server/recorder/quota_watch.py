"""Old recordings go into the bin when all take too much; where that does not help, nothing more is recorded."""

import asyncio

from controller.errors import RecordingError, TendrilError
from controller.system.scheduler import Scheduler
from recordings.store.quota import default_quota, enforce
from recordings.store.store import Store
from server.log.events import EventLog
from server.recorder.client import RecorderClient
from server.recorder.review import Review

QUOTA_S = 60.0
"""Between two looks: a minute of a recording is 35 MB at most."""


class QuotaWatch:
    """Looks once a minute, off the event loop."""

    def __init__(
        self,
        store: Store,
        most: int | None,
        recorder: RecorderClient,
        review: Review,
        events: EventLog,
        scheduler: Scheduler,
    ) -> None:
        self._store, self._recorder, self._review, self._events = store, recorder, review, events
        self._given = most
        self._problem = ""
        self._barred = False
        self._scheduler = scheduler
        self._busy = False

    def look(self) -> None:
        """A job: look, unless the last look is still under way."""
        if not self._busy:
            self._busy = True
            self._scheduler.begin("the look at the recordings' size", self.keep())

    async def keep(self) -> None:
        """Move what is too much, and say once what cannot be moved, or that no one can look."""
        try:
            most = await asyncio.to_thread(self._most)
            if most is None:
                await asyncio.to_thread(self._store.list)  # which notes why no one can look
            else:
                await self._clear_bin()
                await self._enforce(most)
            problem = self._store.problem
        except (OSError, TendrilError) as error:
            problem = f"the recordings' size cannot be looked at: {error}"
        finally:
            self._busy = False
        if problem and problem != self._problem:
            self._events.add(problem, "warning")
        self._problem = problem

    async def _clear_bin(self) -> None:
        gone = await asyncio.to_thread(self._store.clear_bin)
        if gone:
            self._events.add(f"{len(gone)} recordings, deleted more than 7 days ago, were removed: {', '.join(gone)}")

    async def _enforce(self, most: int) -> None:
        bound = f"all together may take {most / 1e9:.3g} GB (TENDRIL_RECORDINGS_QUOTA)"
        found = await asyncio.to_thread(enforce, self._store, most)
        for moved in found.moved:
            text = f"recording {moved.id} was deleted, the oldest: {bound}; it can be restored for 7 days"
            self._events.add(text, "warning")
        if not found.over:
            return self._lift()
        if not self._barred:
            takes = f"those that do not go by themselves take {(most + found.over) / 1e9:.3g} GB"
            self._barred = True
            self._recorder.bar(f"nothing is recorded: {bound}, and {takes}; delete some")  # its watch tells the log
        await self._end()

    async def _end(self) -> None:
        """End what runs; where that fails the next look tries again."""
        if not self._recorder.state().recording:
            return
        try:
            done = await asyncio.to_thread(self._recorder.stop)
        except RecordingError as error:
            return self._events.add(str(error), "warning")
        self._review.stopped(done.id)
        self._events.add(f"recording {done.id} was ended, {done.rows} rows: the quota has no room", "warning")

    def _lift(self) -> None:
        if self._barred:
            self._barred = False
            self._recorder.bar("")
            self._events.add("recordings may begin again: there is room by the quota")

    def _most(self) -> int | None:
        """As given; else by the disk, which is there once there is a recording; None without it."""
        if self._given is not None:
            return self._given
        try:
            return default_quota(self._store.folder)
        except FileNotFoundError:
            return None
