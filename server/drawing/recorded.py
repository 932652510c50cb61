"""A recorded path as a drawing. The reader makes it, so nothing of the server's routes is imported here."""

import re
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from controller.arrays import Values
from controller.errors import ParameterError, sentence
from recordings.exporting.tip_path import Wanted, tip_path
from server.drawing.messages import POINTS_MAX, DrawingBody, Given
from server.drawing.picture import evenly

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
