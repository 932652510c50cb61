"""Recordings: start, stop, list, quick look, edit, remove, download; and their bookmarks."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, NamedTuple

from fastapi import APIRouter, Query, Response
from fastapi import Path as InPath
from pydantic import Field as Bounds
from pydantic import TypeAdapter
from starlette.responses import FileResponse, StreamingResponse

from controller.schema.layout import Model
from recordings.format import frames
from recordings.format.messages import BOOKMARKS_MAX, Bookmark, Profile, Recording, RecordingState
from recordings.format.profiles import PROFILES, ProfileInfo
from recordings.read.metrics import Measured
from recordings.read.query import matching, ordered
from recordings.read.quick import POINTS, Quick, quick_look
from recordings.store.edits import BookmarkLabel, Edit, with_label, without_bookmark
from recordings.store.finishing import measured
from recordings.store.store import Store
from server.access.permit import Holder
from server.http import answers
from server.http.who import Me
from server.log.events import GivenEvents
from server.recorder.by_hand import GivenRecordingByHand
from server.recorder.client import GivenRecorder
from server.recorder.exports import BINARY
from server.recorder.folder import GivenFolder
from server.recorder.review import GivenReview


class RecordingBody(Model):
    """Body of POST /api/recordings."""

    name: Annotated[str, Bounds(max_length=80)] = ""
    profile: Profile = "standard"


router = APIRouter(tags=["recordings"])

LIST = TypeAdapter(list[Recording])

CHUNK = 1 << 18
"""Bytes read at once from a file that is still written."""


@router.get("/api/recordings", response_model=list[Recording])
async def recordings(
    folder: GivenFolder,
    review: GivenReview,
    search: Annotated[str, Query(max_length=200)] = "",
    sort: Annotated[str, Query(max_length=40)] = "-started",
    limit: Annotated[int | None, Query(ge=1)] = None,
    deleted: bool = False,
) -> Response:
    """Every recording, newest first; those with every word of `search`, by any column, at most `limit` of them.

    With `deleted` those in the bin. The headers `x-found` and `x-in-all` say how many fit, and how many there are;
    `x-deleted` how many are in the bin.
    """
    wanted = _Wanted(search, sort, limit, deleted)
    answer, without_picture = await folder.look(_listed, folder.store, wanted)
    review.depict(without_picture)
    return answer


@router.post("/api/recordings")
async def start_recording(body: RecordingBody, hand: GivenRecordingByHand, who: Holder) -> RecordingState:
    """Record every tick from now on; 409 when a recording runs or the disk has no room."""
    return await hand.begin(body.name, body.profile, who.name)


@router.delete("/api/recordings/current")
async def stop_recording(hand: GivenRecordingByHand, who: Holder) -> Recording:
    """End the recording; 409 when none runs."""
    return await hand.end(who.name)


@router.get("/api/recordings/profiles")
async def recording_profiles() -> tuple[ProfileInfo, ...]:
    """The profiles, the default first, with their size per hour."""
    return PROFILES


@router.get("/api/recordings/{id}.rrd", response_class=FileResponse, responses=answers.file(BINARY))
async def recording_file(id: str, folder: GivenFolder, recorder: GivenRecorder) -> Response:
    """The recording's file, for rerun's viewer or for download, as far as it is written; 404 when there is none."""
    path = await folder.look(folder.store.path, id)
    state = recorder.state()
    if state.recording and state.id == id:
        size = await folder.look(frames.whole_length, path)
        headers = {"content-length": str(size), "content-disposition": f'attachment; filename="{id}.rrd"'}
        return StreamingResponse(_first(path, size), headers=headers, media_type=BINARY)
    return FileResponse(path, media_type=BINARY, filename=f"{id}.rrd")


@router.get("/api/recordings/{id}")
async def recording(id: str, folder: GivenFolder) -> Recording:
    """One recording; 404 when there is none."""
    return await folder.look(folder.store.find, id)


@router.get("/api/recordings/{id}/metrics")
async def recording_metrics(id: str, folder: GivenFolder) -> Measured:
    """How well the tip followed, over all and in each cycle, from the data; 404 when there is no such recording."""
    await folder.look(folder.store.path, id)  # only a recording waits for its turn
    return await folder.read(measured, folder.store.folder, id)


@router.patch("/api/recordings/{id}")
async def edit_recording(id: str, body: Edit, folder: GivenFolder, who: Me) -> Recording:
    """Change name, tags, notes or star; 404 when there is no such recording."""
    return await folder.look(folder.store.edit, id, body)


@router.delete("/api/recordings/deleted", status_code=204)
async def empty_bin(folder: GivenFolder, who: Me, events: GivenEvents) -> None:
    """Remove all deleted recordings for good."""
    ids = await folder.look(folder.store.bin.ids)
    await folder.look(folder.store.empty_bin, ids)
    events.add(f"{who.name}: {len(ids)} deleted recordings removed for good")


@router.delete("/api/recordings/{id}", status_code=204)
async def remove_recording(id: str, folder: GivenFolder, who: Me, events: GivenEvents) -> None:
    """Delete a recording; it can be restored for 7 days. 409 while starred or being written."""
    await folder.look(folder.store.remove, id)
    events.add(f"{who.name}: recording {id} deleted")


@router.post("/api/recordings/{id}/restore")
async def restore_recording(id: str, folder: GivenFolder, who: Me, events: GivenEvents) -> Recording:
    """Take a deleted recording back; 404 when it is not there, or gone for good."""
    found = await folder.look(folder.store.restore, id)
    events.add(f"{who.name}: recording {id} restored")
    return found


class _Wanted(NamedTuple):
    search: str
    sort: str
    limit: int | None
    deleted: bool


def _listed(store: Store, wanted: _Wanted) -> tuple[Response, list[str]]:
    """Written as JSON at once: the framework's own way checks every one of them again. And who lacks a picture."""
    everything = store.bin.recordings() if wanted.deleted else store.list()
    found = ordered(matching(everything, wanted.search), wanted.sort)
    counts = {"x-found": len(found), "x-in-all": len(everything), "x-deleted": len(store.bin.ids())}
    headers = {name: str(count) for name, count in counts.items()}
    shown = found[: wanted.limit]
    bare = [one.id for one in shown if one.thumbnail is None and one.complete and not (one.problem or wanted.deleted)]
    return Response(LIST.dump_json(shown), media_type="application/json", headers=headers), bare


def _first(path: Path, size: int) -> Iterator[bytes]:
    """The first `size` bytes of a growing file: its length was promised already."""
    with path.open("rb") as file:
        while size > 0 and (chunk := file.read(min(size, CHUNK))):
            size -= len(chunk)
            yield chunk


Points = Annotated[int, Query(ge=100, le=20_000)]

Keys = Annotated[list[Annotated[str, Query(max_length=80)]], Query(max_length=64)]


@router.get("/api/recordings/{id}/quick", response_model=Quick)
async def recording_quick(id: str, folder: GivenFolder, points: Points = POINTS, signals: Keys = []) -> Response:  # noqa: B006
    """The main signals as extremes of bins, and the tip's path; of a running recording, up to now. 404 without it."""
    path = await folder.look(folder.store.path, id)
    text = await folder.quick_for_all(quick_look, path, points, tuple(signals))
    return Response(text, media_type="application/json", headers={"cache-control": "no-store"})


Number = Annotated[int, InPath(ge=1, le=BOOKMARKS_MAX)]
"""Of a bookmark: set by who operates while a recording runs, named and removed by anyone who operates, seen by all."""


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
