"""Saved drawings: one JSON file each."""

import logging
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

from pydantic import TypeAdapter, ValidationError

from controller.errors import TendrilError
from controller.system.whole_file import read_whole, set_aside, write_whole
from server.drawing.errors import UnknownDrawing
from server.drawing.messages import DrawingBody, DrawingInfo, DrawingName, Duration, Given, Speed
from server.drawing.strokes import length_of, strokes_of
from server.http.given import given

_NAME: TypeAdapter[str] = TypeAdapter(DrawingName)
TOLD_MAX = 20
"""Odd files that the log names."""

log = logging.getLogger(__name__)


class Drawings:
    """The drawings in `folder`, by name."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._told: set[str] = set()

    def listed(self) -> list[DrawingInfo]:
        """All that can be read, the last saved first."""
        found = []
        for path in self._folder.glob("*.json"):
            try:
                found.append(_info(self.read(path.stem), path))
            except (UnknownDrawing, OSError) as error:  # damaged, not ours, or deleted meanwhile
                self._leave_out(path, error)
        return sorted(found, key=lambda info: info.saved, reverse=True)

    def read(self, name: str) -> DrawingBody:
        """The drawing `name`. Raises UnknownDrawing."""
        path = self._path(name)
        try:
            found = DrawingBody.model_validate_json(read_whole(path), extra="ignore")  # a later version may say more
        except OSError as error:
            raise _unknown(name) from error
        except ValidationError as error:
            raise UnknownDrawing(
                f"drawing {name!r} cannot be read: {path} is damaged; delete it, or save again"
            ) from error
        return found.model_copy(update={"name": name})

    def save(self, drawing: DrawingBody) -> DrawingInfo:
        """Write it whole or not at all, in place of one of its name. Raises TendrilError if the disk refuses."""
        path = self._path(drawing.name)
        try:
            self._folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            if path.is_dir():
                set_aside(path)
            write_whole(path, drawing.model_dump_json(exclude_none=True))  # as versions without `pieces` read it
        except OSError as error:
            raise TendrilError(f"{drawing.name} cannot be saved: {error.strerror}") from error
        return _info(drawing, path)

    def delete(self, name: str) -> None:
        """Delete it, even if it is damaged. Raises UnknownDrawing."""
        try:
            self._path(name).unlink()
        except OSError as error:
            raise _unknown(name) from error

    def _leave_out(self, path: Path, why: Exception) -> None:
        """Say once in the log which file holds none; the folder may hold any number of such."""
        if path.name not in self._told and len(self._told) < TOLD_MAX:
            self._told.add(path.name)
            log.warning("%s is left out of the drawings: %s", path, why)

    def _path(self, name: str) -> Path:
        """File of a name; whatever is no name has none."""
        try:
            return self._folder / f"{_NAME.validate_python(name)}.json"
        except ValidationError as error:
            raise _unknown(name) from error


def _unknown(name: str) -> UnknownDrawing:
    return UnknownDrawing(f"there is no drawing {name!r}")


def _info(drawing: DrawingBody, path: Path) -> DrawingInfo:
    """What the list says of a drawing, without planning it."""
    length = length_of(strokes_of(drawing))
    return DrawingInfo(
        name=drawing.name,
        saved=datetime.fromtimestamp(path.stat().st_mtime, UTC),
        length=length,
        duration=_duration(drawing, length),
        points=len(drawing.points),
    )


def _duration(drawing: DrawingBody, length: float) -> float | None:
    """How long the path of `length` [m] takes as drawn [s]; None where the settings decide."""
    match drawing.timing:
        case Speed(speed=speed):
            return length / speed
        case Duration(duration=duration):
            return duration
        case Given() if drawing.times:
            return drawing.times[-1] - drawing.times[0]
    return None


GivenDrawings = Annotated[Drawings, given(Drawings)]
