"""One file of the server's state: what an earlier server kept, or nothing where that cannot be read.

A file that was half written, holds anything else, or is a folder, a pipe or a link stops no start and no answer: it is
as if it were not there, one line in the log says so, and the next save puts it aside under another name.
"""

import logging
from collections.abc import Callable
from pathlib import Path
from typing import Generic, TypeVar

from pydantic import ValidationError

from controller.errors import sentence
from controller.system.whole_file import read_whole, set_aside, write_whole

T = TypeVar("T")

log = logging.getLogger(__name__)

_told: dict[Path, str] = {}
"""What was said last of each file: a page may ask for it many times a second."""


class StateFile(Generic[T]):
    """The file `path`, which `parse` understands (ValidationError or ValueError where it does not); `what` it holds."""

    def __init__(self, path: Path, parse: Callable[[bytes], T], what: str) -> None:
        self.path = path
        self._parse, self._what = parse, what

    def read(self) -> T | None:
        """What it holds; None where there is none, or none that can be used."""
        try:
            found = self._parse(read_whole(self.path))
        except FileNotFoundError:
            return None
        except (OSError, ValueError) as error:  # ValidationError is a ValueError
            self._complain(error)
            return None
        _told.pop(self.path, None)
        return found

    def write(self, content: bytes | str) -> None:
        """Put `content` in its place, on the disk; raises OSError. What could not be read is put aside before."""
        if self.path in _told or self.path.is_dir():
            set_aside(self.path)
        write_whole(self.path, content)
        _told.pop(self.path, None)

    def _complain(self, error: OSError | ValueError) -> None:
        why = sentence(error) if isinstance(error, ValidationError) else getattr(error, "strerror", None) or str(error)
        if _told.get(self.path) != why:
            _told[self.path] = why
            log.warning("%s cannot be used, so %s: %s", self.path, self._what, why)
