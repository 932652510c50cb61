"""Bookmarks: set while a recording runs by who operates, named and removed by anyone who operates, seen by all."""

from typing import Annotated

from fastapi import APIRouter
from fastapi import Path as InPath

from recordings.format.messages import BOOKMARKS_MAX, Bookmark, Recording
from recordings.store.edits import BookmarkLabel, with_label, without_bookmark
from server.access.asking import Holder
from server.http.who import Me
from server.log.events import GivenEvents
from server.recorder.by_hand import GivenRecordingByHand
from server.recorder.client import GivenRecorder
from server.recorder.folder import GivenFolder

router = APIRouter(tags=["recordings"])

Number = Annotated[int, InPath(ge=1, le=BOOKMARKS_MAX)]


@router.post("/api/recordings/current/bookmarks")
async def set_bookmark(body: BookmarkLabel, hand: GivenRecordingByHand, who: Holder) -> Bookmark:
    """Mark the newest row of the recording that runs; 409 when none does, or it has 100 bookmarks already."""
    return await hand.mark(body.label, who.name)


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
