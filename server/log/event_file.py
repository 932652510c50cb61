"""A log on disk, one JSON object a line: appended, rotated once, read back when the next server starts."""

import logging
import os
from pathlib import Path
from typing import Generic, TypeVar

from pydantic import BaseModel, ValidationError

from controller.system.whole_file import is_regular, open_append, open_regular, set_aside

LARGEST = 5_000_000
"""Bytes at which the file becomes the older one; the one before that is dropped."""
READ_BACK = 200
"""Lines that a new server begins with."""
READ_BACK_BYTES = 1_000_000
"""Of the end of each file: enough for that many lines, and no more where it is something else."""

Line = TypeVar("Line", bound=BaseModel)

log = logging.getLogger(__name__)


class EventFile(Generic[Line]):
    """Appends lines of one `kind` to `path`; the file before the last rotation is beside it, ".old" behind the name."""

    def __init__(self, path: Path, kind: type[Line], largest: int = LARGEST) -> None:
        self._path, self._older = path, path.with_name(f"{path.name}.old")
        self._kind, self._largest = kind, largest
        for odd in filter(_is_odd, (self._path, self._older)):
            aside = set_aside(odd)
            log.warning("%s is not a regular file%s", odd, f": it is {aside} now" if aside else "")
        self._torn = not _whole(path)

    def last(self, count: int = READ_BACK) -> list[Line]:
        """The last lines, oldest first; lines that a crash has torn, or another version wrote, are left out."""
        lines = [line for path in (self._older, self._path) for line in _lines(path)]
        found = (self._read(line) for line in lines[-count:])
        return [event for event in found if event is not None]

    def append(self, event: Line) -> None:
        """Add a line; raises OSError where that fails."""
        if self._path.exists() and self._path.stat().st_size >= self._largest:
            self._path.replace(self._older)
        line = "\n" * self._torn + event.model_dump_json() + "\n"
        self._torn = False
        with open_append(self._path) as file:
            file.write(line.encode())

    def _read(self, line: bytes) -> Line | None:
        try:
            return self._kind.model_validate_json(line)
        except ValidationError:
            return None


def _is_odd(path: Path) -> bool:
    return os.path.lexists(path) and not is_regular(path)


def _whole(path: Path) -> bool:
    """Whether the file ends with a whole line (or is not there): what comes next must not hang on to half of one."""
    try:
        with open_regular(path) as file:
            file.seek(-1, os.SEEK_END)
            return file.read() == b"\n"
    except OSError:
        return True


def _lines(path: Path) -> list[bytes]:
    try:
        with open_regular(path) as file:
            torn = file.seek(max(0, os.fstat(file.fileno()).st_size - READ_BACK_BYTES)) > 0
            return file.read(READ_BACK_BYTES).splitlines()[torn:]
    except OSError:
        return []
