"""A recorded path as a drawing, so that the Run tab can follow it again."""

import re
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from fastapi import APIRouter, Query
from pydantic import ValidationError

from controller.arrays import Values
from controller.errors import ParameterError, sentence
from controller.schema.parameters import SENSORS
from recordings.exporting.tip_path import Wanted, What, tip_path
from server.drawing.messages import POINTS_MAX, DrawingBody, Given
from server.drawing.picture import evenly
from server.recorder.export_routes import From, To
from server.recorder.folder import GivenFolder

DECIMALS = 6
"""Of its times [s] and points [m]."""
NAME_LENGTH = 80


def recorded_drawing(source: Path, name: str, wanted: Wanted) -> DrawingBody:
    """The path with its times, evenly thinned to what a drawing holds. ParameterError when it cannot be one."""
    t, p = tip_path(source, wanted)
    keep = evenly(len(t), POINTS_MAX)
    try:
        return DrawingBody(name=drawing_name(name), points=_plain(p[keep]), times=_plain(t[keep]), timing=Given())
    except ValidationError as error:
        raise ParameterError(sentence(error)) from error


def drawing_name(name: str) -> str:
    """The recording's name with what a drawing's may not hold left out."""
    plain = re.sub(r"[^A-Za-z0-9_ .-]+", " ", name).strip(" .-").removesuffix(".csv")
    return " ".join(plain.split())[:NAME_LENGTH].strip(" .-") or "recorded"


def _plain(values: Values) -> Any:
    return np.round(values, DECIMALS).tolist()


router = APIRouter(tags=["recordings"])

Rod = Annotated[int, Query(ge=1, le=SENSORS)]


@router.get("/api/recordings/{id}/path")
async def recording_path(
    id: str,
    folder: GivenFolder,
    what: What = "p_meas",
    rod: Rod = SENSORS,
    start: From = None,
    stop: To = None,
) -> DrawingBody:
    """The path of the tip, its reference or a marker as a drawing with times; 404, or 422 says what is wrong."""
    found, source = await folder.look(folder.store.find, id), await folder.look(folder.store.path, id)
    wanted = Wanted(what, rod, start, stop)
    return await folder.read(recorded_drawing, source, found.name, wanted)
