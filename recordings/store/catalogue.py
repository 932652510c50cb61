"""The list of all recordings, quickly: a sidecar is read again only when it has changed, even after a restart."""

import contextlib
import gc
import logging
import os
import threading
from collections.abc import Iterator
from pathlib import Path

from pydantic import TypeAdapter

from controller.errors import RecordingError
from controller.schema.layout import Model
from controller.system.whole_file import read_whole, write_whole
from recordings.format import sidecar
from recordings.format.messages import Recording

INDEX = ".index.json"
STALE_MAX = 50
"""Sidecars that may differ from the index file before it is written again: a running one changes every second."""


class Entry(Model):
    """A recording as its sidecar said when that had the mark: inode, time of change [ns] and size."""

    mark: tuple[int, int, int]
    recording: Recording


INDEX_MOST = 1 << 28
"""Bytes of it that are read: it takes 1 kB a recording."""
TOLD_MAX = 20
"""Odd things in the folder that the log names; of more there is one line."""

log = logging.getLogger(__name__)

ENTRIES = TypeAdapter(dict[str, Entry])


class Catalogue:
    """Every recording in `folder`, the damaged ones included. May be asked from any thread."""

    def __init__(self, folder: Path, keep_index: bool = True) -> None:
        self._folder, self._keep_index = folder, keep_index
        self._entries: dict[str, Entry] | None = None
        self._lock = threading.Lock()
        self._told: set[str] = set()
        self._seen = False
        self.problem = ""
        """Why the folder could not be read the last time, "" when it could."""

    def list(self) -> list[Recording]:
        """All of them in no order; `problem` says what is wrong with one. None where the folder cannot be read."""
        with self._lock, _no_collection():
            try:
                marks, data = self._scan()
            except OSError as error:
                if self._seen or not isinstance(error, FileNotFoundError):  # before the first recording there is none
                    self._complain(f"recordings in {self._folder} cannot be listed: {error.strerror}")
                return []
            self.problem, self._seen = "", True
            entries = self._refreshed(marks)
        listed = [self._shown(entry.recording, id in data) for id, entry in entries.items()]
        # A writer that begins has data before it has a sidecar, and holds them.
        left = [id for id in data - marks.keys() if sidecar.is_free(sidecar.rrd_path(self._folder, id))]
        blanks = (sidecar.blank(id, problem="its description is missing") for id in left)
        return listed + [self._shown(blank, has_data=True) for blank in blanks]

    def _shown(self, recording: Recording, has_data: bool) -> Recording:
        """As its description says, but for data that are not there, and for the size where it says none."""
        if not has_data:
            return recording.model_copy(update={"problem": recording.problem or "its data is missing"})
        if recording.bytes:
            return recording
        with contextlib.suppress(OSError):  # removed this moment
            size = sidecar.rrd_path(self._folder, recording.id).lstat().st_size
            return recording.model_copy(update={"bytes": size})
        return recording

    def _scan(self) -> tuple[dict[str, tuple[int, int, int]], set[str]]:
        """Marks of all sidecars by id, and the ids of all data."""
        marks: dict[str, tuple[int, int, int]] = {}
        data: set[str] = set()
        with os.scandir(self._folder) as files:
            for file in files:
                id, _, kind = file.name.rpartition(".")
                if kind not in ("json", "rrd") or not sidecar.is_id(id):
                    continue
                if not file.is_file(follow_symlinks=False):
                    self._leave_out(file.name)
                elif kind == "rrd":
                    data.add(id)
                else:
                    with contextlib.suppress(FileNotFoundError):  # removed this moment
                        found = file.stat(follow_symlinks=False)
                        marks[id] = found.st_ino, found.st_mtime_ns, found.st_size
        return marks, data

    def _complain(self, problem: str) -> None:
        if problem != self.problem:
            self.problem = problem
            log.warning("%s", problem)

    def _leave_out(self, name: str) -> None:
        """Say once that `name` is no file of ours; the folder may hold any number of such."""
        if name in self._told or len(self._told) > TOLD_MAX:
            return
        self._told.add(name)
        more = len(self._told) > TOLD_MAX
        what = "more there is not told" if more else f"{name} is not a regular file: it is left out"
        log.warning("%s: %s", self._folder, what)

    def _refreshed(self, marks: dict[str, tuple[int, int, int]]) -> dict[str, Entry]:
        known = self._load() if self._entries is None else self._entries
        same = {id: known[id] for id, mark in marks.items() if id in known and known[id].mark == mark}
        read = {id: self._read(id) for id in marks if id not in same}
        new = {id: Entry(mark=marks[id], recording=found) for id, (found, _) in read.items()}
        self._entries = same | {id: new[id] for id, (_, lasting) in read.items() if lasting}
        if self._keep_index and len(new) > STALE_MAX:
            self._save(self._entries)
        return same | new

    def _read(self, id: str) -> tuple[Recording, bool]:
        """What its description says, and whether that stays so: a disk that failed to give it may give it next time."""
        try:
            return sidecar.read(self._folder, id), True
        except RecordingError as error:
            return sidecar.blank(id, problem=str(error)), not isinstance(error.__cause__, OSError)

    def _load(self) -> dict[str, Entry]:
        try:
            entries = ENTRIES.validate_json(read_whole(self._folder / INDEX, INDEX_MOST))
        except (OSError, ValueError):  # none yet, or of another version: it can be made again
            return {}
        return {id: entry for id, entry in entries.items() if not entry.recording.problem}  # it may be mended by now

    def _save(self, entries: dict[str, Entry]) -> None:
        with contextlib.suppress(OSError):  # a full disk makes the next start slower, no more
            text = ENTRIES.dump_json(entries, exclude_defaults=True)
            write_whole(self._folder / INDEX, text, lasting=False)


@contextlib.contextmanager
def _no_collection() -> Iterator[None]:
    """Thousands of new objects and no garbage: looking for it would take longer than making them."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
