"""What who operates does with the recording that runs: begin it, mark it, end it; by a button, or by a macro."""

import asyncio
from dataclasses import dataclass
from typing import Annotated

from controller.errors import CommandRefused, RecordingError
from controller.system.scheduler import Scheduler
from recordings.format.messages import Bookmark, Profile, Recording, RecordingState
from recordings.store.edits import with_bookmark
from recordings.write.session import Context
from server.http.given import given
from server.log.events import EventLog
from server.operate.operator import Operator
from server.recorder.client import RecorderClient
from server.recorder.folder import RecordingsFolder
from server.recorder.review import Review
from server.rig.client import Rig


@dataclass(frozen=True)
class RecordingByHand:
    """Each refuses by CommandRefused; `name` is whose hand it is, for the log.

    What the recorder was asked for it does, and the rest with it, though who waits is cancelled, as a macro's step.
    """

    recorder: RecorderClient
    folder: RecordingsFolder
    review: Review
    rig: Rig
    operator: Operator
    events: EventLog
    scheduler: Scheduler

    async def begin(self, title: str, profile: Profile, name: str) -> RecordingState:
        """Record every tick from now on; refused when a recording runs or the disk has no room."""
        return await self.scheduler.to_its_end("the begin of a recording", self._begin(title, profile, name))

    async def _begin(self, title: str, profile: Profile, name: str) -> RecordingState:
        info, context = self.rig.require_info(), Context(profile=profile, operator=name)
        try:
            state = await asyncio.to_thread(self.recorder.start, title, info, self.operator.settings, context)
        except RecordingError as error:
            raise CommandRefused(str(error)) from error
        self.events.add(f"{name}: recording {state.id} started")
        return state

    async def mark(self, label: str, name: str) -> Bookmark:
        """Mark the newest row; refused when nothing is recorded, or it has 100 bookmarks already."""
        return await self.scheduler.to_its_end("a bookmark", self._mark(label, name))

    async def _mark(self, label: str, name: str) -> Bookmark:
        try:
            id, mark = await asyncio.to_thread(self.recorder.mark, label)
        except RecordingError as error:
            raise CommandRefused(str(error)) from error
        revised = await self.folder.look(self.folder.store.revise, id, lambda found: with_bookmark(found, mark))
        self.recorder.bookmarked(revised)
        self.events.add(f"{name}: {_words(mark)} at {mark.t:.2f} s of recording {id}")
        return mark

    async def end(self, name: str) -> Recording:
        """End the recording; refused when none runs."""
        return await self.scheduler.to_its_end("the end of a recording", self._end(name))

    async def _end(self, name: str) -> Recording:
        try:
            found = await asyncio.to_thread(self.recorder.stop)
        except RecordingError as error:
            raise CommandRefused(str(error)) from error
        self.review.stopped(found.id)
        self.events.add(f"{name}: recording {found.id} stopped, {found.rows} rows, {found.gaps} gaps")
        return found


def _words(mark: Bookmark) -> str:
    return f"bookmark {mark.n}" + (f" \u201c{mark.label}\u201d" if mark.label else "")


GivenRecordingByHand = Annotated[RecordingByHand, given(RecordingByHand)]
