"""Bookmarks: set while a recording runs by who operates, named and removed by anyone who operates, seen by all."""

import asyncio
from typing import Annotated

from fastapi import APIRouter
from fastapi import Path as InPath

from controller.errors import CommandRefused, RecordingError
from recordings.format.messages import BOOKMARKS_MAX, Bookmark, Recording
from recordings.store.edits import BookmarkLabel, with_bookmark, with_label, without_bookmark
from server.access.asking import Holder
from server.http.who import Me
from server.log.events import GivenEvents
from server.recorder.folder import GivenFolder, GivenRecorder

router = APIRouter(tags=["recordings"])

Number = Annotated[int, InPath(ge=1, le=BOOKMARKS_MAX)]


@router.post("/api/recordings/current/bookmarks")
async def set_bookmark(
    body: BookmarkLabel, recorder: GivenRecorder, folder: GivenFolder, who: Holder, events: GivenEvents
) -> Bookmark:
    """Mark the newest row of the recording that runs; 409 when none does, or it has 100 bookmarks already."""
    try:
        id, mark = await asyncio.to_thread(recorder.mark, body.label)
    except RecordingError as error:
        raise CommandRefused(str(error)) from error
    recorder.bookmarked(await folder.look(folder.store.revise, id, lambda found: with_bookmark(found, mark)))
    events.add(f"{who.name}: {_words(mark)} at {mark.t:.2f} s of recording {id}")
    return mark


@router.patch("/api/recordings/{id}/bookmarks/{n}")
async def name_bookmark(
    id: str, n: Number, body: BookmarkLabel, recorder: GivenRecorder, folder: GivenFolder, who: Me
) -> Recording:
    """Give a bookmark another label, "" for none; 404 when there is no such one."""
    found = await folder.look(folder.store.revise, id, lambda found: with_label(found, n, body.label))
    recorder.bookmarked(found)
    return found


@router.delete("/api/recordings/{id}/bookmarks/{n}")
async def remove_bookmark(
    id: str, n: Number, recorder: GivenRecorder, folder: GivenFolder, who: Me, events: GivenEvents
) -> Recording:
    """Remove a bookmark; 404 when there is no such one."""
    found = await folder.look(folder.store.revise, id, lambda found: without_bookmark(found, n))
    recorder.bookmarked(found)
    events.add(f"{who.name}: bookmark {n} of recording {id} removed")
    return found


def _words(mark: Bookmark) -> str:
    return f"bookmark {mark.n}" + (f" \u201c{mark.label}\u201d" if mark.label else "")
