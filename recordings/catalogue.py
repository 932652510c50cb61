"""The list of all recordings, quickly: a sidecar is read again only when it has changed, even after a restart."""

import contextlib
import gc
import os
import threading
from collections.abc import Iterator
from pathlib import Path

from pydantic import TypeAdapter

from controller.errors import RecordingError
from controller.layout import Model
from controller.whole_file import SHARED, write_whole
from recordings import sidecar
from recordings.messages import Recording

INDEX = ".index.json"
STALE_MAX = 50
"""So many sidecars may differ from the index file before it is written again: a running one changes every second."""


class Entry(Model):
    """A recording as its sidecar said when that had the mark: inode, time of change [ns] and size."""

    mark: tuple[int, int, int]
    recording: Recording


ENTRIES = TypeAdapter(dict[str, Entry])


class Catalogue:
    """Every recording in `folder`, the damaged ones included. May be asked from any thread."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._entries: dict[str, Entry] | None = None
        self._lock = threading.Lock()

    def list(self) -> list[Recording]:
        """All of them in no order; `problem` says what is wrong with one."""
        with self._lock, _no_collection():
            marks, data = self._scan()
            entries = self._refreshed(marks)
        listed = [_shown(entry.recording, id in data) for id, entry in entries.items()]
        # A writer that begins has data before it has a sidecar, and holds them.
        left = [id for id in data - marks.keys() if sidecar.is_free(sidecar.rrd_path(self._folder, id))]
        return listed + [sidecar.blank(id, problem="its description is missing") for id in left]

    def _scan(self) -> tuple[dict[str, tuple[int, int, int]], set[str]]:
        """Marks of all sidecars by id, and the ids of all data."""
        marks: dict[str, tuple[int, int, int]] = {}
        data: set[str] = set()
        with os.scandir(self._folder) as files:
            for file in files:
                id, _, kind = file.name.rpartition(".")
                if kind not in ("json", "rrd") or not sidecar.is_id(id):
                    continue
                if kind == "rrd":
                    data.add(id)
                    continue
                try:
                    found = file.stat()
                except FileNotFoundError:  # removed this moment
                    continue
                marks[id] = found.st_ino, found.st_mtime_ns, found.st_size
        return marks, data

    def _refreshed(self, marks: dict[str, tuple[int, int, int]]) -> dict[str, Entry]:
        known = self._load() if self._entries is None else self._entries
        same = {id: known[id] for id, mark in marks.items() if id in known and known[id].mark == mark}
        new = {id: Entry(mark=mark, recording=self._read(id)) for id, mark in marks.items() if id not in same}
        self._entries = same | new
        if len(new) > STALE_MAX:
            self._save(self._entries)
        return self._entries

    def _read(self, id: str) -> Recording:
        try:
            return sidecar.read(self._folder, id)
        except RecordingError as error:
            return sidecar.blank(id, problem=str(error))

    def _load(self) -> dict[str, Entry]:
        try:
            return ENTRIES.validate_json((self._folder / INDEX).read_bytes())
        except (OSError, ValueError):  # none yet, or of another version: it can be made again
            return {}

    def _save(self, entries: dict[str, Entry]) -> None:
        with contextlib.suppress(OSError):  # a full disk makes the next start slower, no more
            text = ENTRIES.dump_json(entries, exclude_defaults=True)
            write_whole(self._folder / INDEX, text, SHARED, lasting=False)


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


def _shown(recording: Recording, has_data: bool) -> Recording:
    if has_data or recording.problem:
        return recording
    return recording.model_copy(update={"problem": "its data is missing"})
