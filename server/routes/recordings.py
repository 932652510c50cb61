"""Recordings: start, stop, list, download."""

import asyncio
from collections.abc import Iterator
from pathlib import Path

from fastapi import APIRouter, Response
from starlette.responses import FileResponse, StreamingResponse

from controller.errors import CommandRefused, RecordingError
from recordings.messages import Recording, RecordingState
from recordings.session import Context
from server.deps import Holder, Parts
from server.messages import RecordingBody

router = APIRouter(tags=["recordings"])

BINARY = "application/octet-stream"
CHUNK = 1 << 18
"""Bytes read at once from a file that is still written."""


@router.get("/api/recordings")
async def recordings(parts: Parts) -> list[Recording]:
    """Every recording, newest first."""
    return await asyncio.to_thread(parts.store.list)


@router.post("/api/recordings")
async def start_recording(body: RecordingBody, parts: Parts, who: Holder) -> RecordingState:
    """Record every tick from now on; 409 when a recording runs or the disk has no room."""
    info, settings = parts.require_info(), parts.operator.settings
    context = Context(profile=body.profile, operator=who.name)
    try:
        state = await asyncio.to_thread(parts.recorder.start, body.name, info, settings, context)
    except RecordingError as error:
        raise CommandRefused(str(error)) from error
    parts.events.add(f"{who.name}: recording {state.id} started")
    return state


@router.delete("/api/recordings/current")
async def stop_recording(parts: Parts, who: Holder) -> Recording:
    """End the recording; 409 when none runs."""
    try:
        found = await asyncio.to_thread(parts.recorder.stop)
    except RecordingError as error:
        raise CommandRefused(str(error)) from error
    parts.review.stopped(found.id)
    parts.events.add(f"{who.name}: recording {found.id} stopped, {found.rows} rows, {found.gaps} gaps")
    return found


@router.get("/api/recordings/{id}.rrd", response_class=FileResponse)
async def recording_file(id: str, parts: Parts) -> Response:
    """The recording's file, for rerun's viewer or for download; 404 when there is none."""
    path = parts.store.path(id)
    state = parts.recorder.state()
    if state.recording and state.id == id:
        size = path.stat().st_size
        headers = {"content-length": str(size), "content-disposition": f'attachment; filename="{id}.rrd"'}
        return StreamingResponse(_first(path, size), headers=headers, media_type=BINARY)
    return FileResponse(path, media_type=BINARY, filename=f"{id}.rrd")


def _first(path: Path, size: int) -> Iterator[bytes]:
    """The first `size` bytes of a growing file: its length was promised already."""
    with path.open("rb") as file:
        while size > 0 and (chunk := file.read(min(size, CHUNK))):
            size -= len(chunk)
            yield chunk
