"""A recorded path is asked for, so that the Run tab can follow it again."""

from typing import Annotated

from fastapi import APIRouter, Query

from controller.schema.parameters import SENSORS
from recordings.exporting.tip_path import Wanted, What
from server.drawing.messages import DrawingBody
from server.drawing.recorded import recorded_drawing
from server.recorder.export_routes import From, To
from server.recorder.folder import GivenFolder

router = APIRouter(tags=["recordings"])

Rod = Annotated[int, Query(ge=1, le=SENSORS)]
Run = Annotated[bool, Query()]
"""Only what figures are taken of: without pre-roll and approach. It takes the place of the window."""


@router.get("/api/recordings/{id}/path")
async def recording_path(
    id: str,
    folder: GivenFolder,
    what: What = "p_meas",
    rod: Rod = SENSORS,
    start: From = None,
    stop: To = None,
    run: Run = False,
) -> DrawingBody:
    """The path of the tip, its reference or a marker as a drawing with times; 404, or 422 says what is wrong."""
    found, source = await folder.look(folder.store.find, id), await folder.look(folder.store.path, id)
    wanted = Wanted(what, rod, start, stop, run)
    return await folder.read(recorded_drawing, source, found.name, wanted)
