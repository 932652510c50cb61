"""Recordings going out as files or as paths to follow, and coming in from elsewhere."""

import asyncio
import shutil
import tempfile
from pathlib import Path
from typing import Annotated, Literal

from fastapi import APIRouter, Body, Query
from starlette.background import BackgroundTask
from starlette.responses import FileResponse

from controller.errors import CommandRefused, RecordingError
from controller.schema.parameters import SENSORS
from recordings.exporting.apart import apart
from recordings.exporting.export import Format, export
from recordings.exporting.signals import SignalInfo, offered
from recordings.exporting.table import Choice
from recordings.exporting.tip_path import Wanted, What
from recordings.format.messages import Recording
from recordings.importing.text import import_text
from server import answers
from server.deps import Holder, Parts
from server.drawings.messages import DrawingBody
from server.recorded_path import recorded_drawing

router = APIRouter(tags=["recordings"])

From = Annotated[float | None, Query(alias="from", allow_inf_nan=False)]
To = Annotated[float | None, Query(alias="to", allow_inf_nan=False)]
Rod = Annotated[int, Query(ge=1, le=SENSORS)]
Name = Annotated[str, Query(min_length=1, max_length=80)]
BINARY = "application/octet-stream"
MEDIA = {"csv": "text/csv; charset=utf-8", "parquet": "application/vnd.apache.parquet"}
TYPES = ("text/csv", MEDIA["parquet"], BINARY)


@router.get("/api/recordings/{id}/signals")
async def recording_signals(id: str, parts: Parts) -> list[SignalInfo]:
    """What can be chosen for an export; 404 without such a recording."""
    return offered(await parts.look(parts.store.find, id))


@router.get("/api/recordings/{id}/export", response_class=FileResponse, responses=answers.file(*TYPES))
async def export_recording(
    id: str,
    parts: Parts,
    kind: Annotated[Format, Query(alias="format")],
    signals: Annotated[str, Query(max_length=8000)] = "",
    start: From = None,
    stop: To = None,
) -> FileResponse:
    """Signals (names joined by commas; all without) from `from` to `to` [s] as a file; 404, or 422 with the reason."""
    source, names = await parts.look(parts.store.path, id), tuple(filter(None, map(str.strip, signals.split(","))))
    folder = tempfile.mkdtemp(prefix="tendril-export-")
    target = Path(folder, f"{id}.{kind}")
    try:
        async with parts.export_lock:
            await asyncio.to_thread(apart, export, source, target, kind, Choice(names, start, stop))
    except BaseException:
        shutil.rmtree(folder)
        raise
    media = MEDIA.get(kind, BINARY)
    after = BackgroundTask(shutil.rmtree, folder)
    return FileResponse(target, media_type=media, filename=target.name, background=after)


@router.get("/api/recordings/{id}/path")
async def recording_path(
    id: str,
    parts: Parts,
    what: What = "p_meas",
    rod: Rod = SENSORS,
    start: From = None,
    stop: To = None,
) -> DrawingBody:
    """The path of the tip, its reference or a marker as a drawing with times; 404, or 422 says what is wrong."""
    found, source = await parts.look(parts.store.find, id), await parts.look(parts.store.path, id)
    wanted = Wanted(what, rod, start, stop)
    async with parts.export_lock:
        return await asyncio.to_thread(apart, recorded_drawing, source, found.name, wanted)


@router.post("/api/recordings/import")
async def import_recording(
    name: Name,
    text: Annotated[bytes, Body(media_type="text/csv")],
    parts: Parts,
    who: Holder,
    time_unit: Literal["s", "ms", "us", "ns"] = "s",
    length_unit: Literal["m", "cm", "mm"] = "m",
) -> Recording:
    """A CSV file with columns time, x, y as a recording; the units hold where its header has none; 409 without room."""
    units = {"t": time_unit, "x": length_unit, "y": length_unit}
    try:
        found = await asyncio.to_thread(import_text, parts.store.folder, name, text, units)
    except RecordingError as error:
        raise CommandRefused(str(error)) from error
    parts.events.add(f"{who.name}: {name} imported as recording {found.id}, {found.rows} rows")
    return found
