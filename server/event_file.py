"""A log on disk, one JSON object a line: appended, rotated once, read back when the next server starts."""

import os
from pathlib import Path
from typing import Generic, TypeVar

from pydantic import BaseModel, ValidationError

LARGEST = 5_000_000
"""Bytes at which the file becomes the older one; the one before that is dropped."""
READ_BACK = 200
"""Lines that a new server begins with."""

Line = TypeVar("Line", bound=BaseModel)


class EventFile(Generic[Line]):
    """Appends lines of one `kind` to `path`; the file before the last rotation is beside it, ".old" behind the name."""

    def __init__(self, path: Path, kind: type[Line], largest: int = LARGEST) -> None:
        self._path, self._older = path, path.with_name(f"{path.name}.old")
        self._kind, self._largest = kind, largest
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
        with os.fdopen(os.open(self._path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600), "a") as file:
            file.write(line)

    def _read(self, line: bytes) -> Line | None:
        try:
            return self._kind.model_validate_json(line)
        except ValidationError:
            return None


def _whole(path: Path) -> bool:
    """Whether the file ends with a whole line (or is not there): what comes next must not hang on to half of one."""
    try:
        with path.open("rb") as file:
            file.seek(-1, os.SEEK_END)
            return file.read() == b"\n"
    except OSError:
        return True


def _lines(path: Path) -> list[bytes]:
    try:
        return path.read_bytes().splitlines()
    except OSError:
        return []
