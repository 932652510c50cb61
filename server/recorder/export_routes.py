"""Recordings going out as files, and coming in from elsewhere."""

from typing import Annotated, Literal

from fastapi import APIRouter, Body, Query, Request
from pydantic import Field as Bounds
from starlette.responses import FileResponse

from controller.errors import CommandRefused, RecordingError
from controller.schema.layout import Model
from controller.text.header import LengthUnit, TimeUnit
from recordings.exporting.export import By, Format, export, export_for_viewer
from recordings.exporting.signals import SignalInfo, offered
from recordings.exporting.table import Choice
from recordings.format.messages import Recording
from recordings.importing.tip import import_text
from server.access.permit import Holder
from server.http import answers
from server.log.events import GivenEvents
from server.recorder.exports import BINARY, MEDIA, ExportMade, GivenExports, size
from server.recorder.folder import GivenFolder

router = APIRouter(tags=["recordings"])

From = Annotated[float | None, Query(alias="from", allow_inf_nan=False)]
To = Annotated[float | None, Query(alias="to", allow_inf_nan=False)]
Name = Annotated[str, Query(min_length=1, max_length=80)]
TYPES = ("text/csv", MEDIA["parquet"], BINARY)


@router.get("/api/recordings/{id}/signals")
async def recording_signals(id: str, folder: GivenFolder) -> list[SignalInfo]:
    """What can be chosen for an export; 404 without such a recording."""
    return offered(await folder.look(folder.store.find, id))


@router.get("/api/recordings/{id}/shown.rrd", response_class=FileResponse, responses=answers.file(BINARY))
async def shown_recording(
    id: str, folder: GivenFolder, exports: GivenExports, request: Request, theme: Literal["dark", "light"] = "dark"
) -> FileResponse:
    """The recording for rerun's viewer beside the page: in mm, kPa and mN m, on a ground of `theme`; 404 without it.

    For any other use /api/recordings/{id}.rrd is the recording itself, in SI units.
    """
    source = await folder.look(folder.store.path, id)
    needs = await folder.look(size, source)
    dark = theme == "dark"
    file = await exports.written(
        request, f"{id}.rrd", lambda target: folder.read(export_for_viewer, source, target, dark), needs
    )
    return exports.sent(file)


@router.get("/api/recordings/{id}/export", response_class=FileResponse, responses=answers.file(*TYPES))
async def export_recording(
    id: str,
    folder: GivenFolder,
    exports: GivenExports,
    request: Request,
    kind: Annotated[Format, Query(alias="format")],
    signals: Annotated[str, Query(max_length=8000)] = "",
    start: From = None,
    stop: To = None,
    comments: bool = False,
) -> FileResponse:
    """Signals (names joined by commas; all without) from `from` to `to` [s] as a file; 404, or 422 with the reason.

    With `comments` a CSV file begins with its origin, as lines with #.
    """
    source, names = await folder.look(folder.store.path, id), tuple(filter(None, map(str.strip, signals.split(","))))
    choice, by = Choice(names, start, stop), By(comments=comments)
    needs = await folder.look(size, source) if kind == "rrd" else 0
    file = await exports.written(
        request, f"{id}.{kind}", lambda target: folder.read(export, source, target, kind, choice, by), needs
    )
    return exports.sent(file)


class ExportBody(Model):
    """Body of POST /api/recordings/{id}/exports: `signals` by name (none: all), `start` to `stop` [s]."""

    format: Format
    signals: Annotated[tuple[Annotated[str, Bounds(max_length=80)], ...], Bounds(max_length=400)] = ()
    start: Annotated[float, Bounds(allow_inf_nan=False)] | None = None
    stop: Annotated[float, Bounds(allow_inf_nan=False)] | None = None
    comments: bool = False
    """A CSV file begins with its origin, as lines with #."""


@router.post("/api/recordings/{id}/exports")
async def make_export(
    id: str, body: ExportBody, folder: GivenFolder, exports: GivenExports, request: Request
) -> ExportMade:
    """Make the file that GET /api/exports/{key} then gives, once, within 10 minutes. Who hangs up cancels it."""
    source = await folder.look(folder.store.path, id)
    choice, by = Choice(body.signals, body.start, body.stop), By(comments=body.comments)
    return await exports.make(folder, request, source, body.format, choice, by)


@router.get("/api/exports/{key}", response_class=FileResponse, responses=answers.file(*TYPES))
async def fetch_export(key: str, exports: GivenExports) -> FileResponse:
    """The file that was made; 404 when it was fetched before, or is too old."""
    return exports.take(key)


@router.post("/api/recordings/import")
async def import_recording(
    name: Name,
    text: Annotated[bytes, Body(media_type="text/csv")],
    folder: GivenFolder,
    who: Holder,
    events: GivenEvents,
    time_unit: TimeUnit = "s",
    length_unit: LengthUnit = "m",
) -> Recording:
    """A CSV file with columns time, x, y as a recording; the units hold where its header has none; 409 without room."""
    units = {"t": time_unit, "x": length_unit, "y": length_unit}
    try:
        found, notes = await folder.quick(import_text, folder.store.folder, name, text, units)
    except RecordingError as error:
        raise CommandRefused(str(error)) from error
    events.add(f"{who.name}: {name} imported as recording {found.id}, {'; '.join([f'{found.rows} rows', *notes])}")
    return found
