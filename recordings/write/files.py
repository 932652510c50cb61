"""Who writes the file of a recording: this process, or one of its own, which then alone has rerun in its memory."""

from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from controller.arrays import Rows
from controller.errors import ProcessKilled, RecordingError
from controller.system.work_process import WorkProcess
from recordings.format.about import About
from recordings.format.annotations import Annotation

if TYPE_CHECKING:
    from recordings.write.rrd import RrdFile

KILLED = "the process that wrote it was killed"
ABANDON_TIMEOUT = 2.0
"""Longest wait for the end of a file that failed [s]."""


class RowsFile(Protocol):
    """What a session needs of its file; see `recordings.write.rrd.RrdFile`."""

    def write(self, rows: Rows) -> None:
        """Append rows (n,), n >= 1."""

    def annotate(self, annotation: Annotation) -> None:
        """Note it at the newest row."""

    def flush(self) -> None:
        """Hand everything to the operating system."""

    def close(self) -> None:
        """Write the footer and close the file."""

    def abandon(self) -> None:
        """Close a file that takes no more."""


class WriterKilled(RecordingError):
    """The process that wrote the file was killed: it holds what had reached the system until then."""


class Files(Protocol):
    """Opens files, in whichever process."""

    def open(self, path: Path, about: About) -> RowsFile:
        """A new file; RecordingError where it cannot be written."""

    def ready(self) -> None:
        """Have who writes there, with all that the first file needs, however long that takes."""


class FilesHere:
    """Written by this process."""

    def __init__(self) -> None:
        from recordings.write import rrd  # not for a process that has its files written elsewhere

        self._rrd, self._is_ready = rrd, False

    def open(self, path: Path, about: About) -> "RrdFile":
        """As of `Files`."""
        return self._rrd.RrdFile(path, about)

    def ready(self) -> None:
        """As of `Files`."""
        if not self._is_ready:
            self._is_ready = True
            with suppress(Exception):  # a full disk, say: the first recording will tell
                self._rrd.warm_up()


class FilesApart:
    """Written by the process `writer`."""

    def __init__(self, writer: WorkProcess) -> None:
        self._writer = writer

    def open(self, path: Path, about: About) -> RowsFile:
        """As of `Files`."""
        _asked(self._writer, _open, path, about)
        return _FileApart(self._writer, path)

    def ready(self) -> None:
        """As of `Files`."""
        _asked(self._writer, _ready)


class _FileApart:
    """A file of the process `writer`. Every call waits for its answer, so what is refused there is raised here."""

    def __init__(self, writer: WorkProcess, path: Path) -> None:
        self._writer, self._path = writer, path
        self._process = writer.pid

    def write(self, rows: Rows) -> None:
        self._do("write", rows)

    def annotate(self, annotation: Annotation) -> None:
        self._do("annotate", annotation)

    def flush(self) -> None:
        self._do("flush")

    def close(self) -> None:
        self._do("close")

    def abandon(self) -> None:
        with suppress(WriterKilled):  # then there is nothing to be closed
            self._do("abandon")

    def _do(self, name: str, *arguments: object) -> None:
        if self._writer.pid != self._process:  # another one would only say the same, once it had started
            raise WriterKilled(KILLED)
        _asked(self._writer, _act, self._path, name, arguments)


def _asked(writer: WorkProcess, work: Callable[..., None], *arguments: Any) -> None:
    try:
        writer.call(work, *arguments)
    except ProcessKilled as error:
        raise WriterKilled(KILLED) from error


_open_files: "dict[Path, RrdFile]" = {}
"""Of the writing process."""


@cache
def _here() -> FilesHere:
    return FilesHere()


def _ready() -> None:
    _here().ready()


def _open(path: Path, about: About) -> None:
    _open_files[path] = _here().open(path, about)


def _act(path: Path, name: str, arguments: tuple[object, ...]) -> None:
    """A file that this process has not opened was another one's, which is dead."""
    if path not in _open_files:
        raise WriterKilled(KILLED)
    file = _open_files.pop(path) if name in ("close", "abandon") else _open_files[path]
    getattr(file, name)(*arguments)
