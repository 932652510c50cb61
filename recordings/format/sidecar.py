"""The small JSON file beside each .rrd: what the list shows, so listing needs neither rerun nor the data.

Also the ids (they become file names and come back in URLs) and the lock that tells a running writer from a killed one.
"""

import fcntl
import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import BinaryIO

from pydantic import ValidationError

from controller.errors import RecordingError
from controller.system.whole_file import PRIVATE, open_lock, open_regular, read_whole, write_whole
from recordings.format.messages import Recording

ID = re.compile(r"[0-9]{8}-[0-9]{6}(-[a-z0-9]{1,40}){0,25}", re.ASCII)
ID_LENGTH = 100
FOLDER_MODE = 0o700
"""Of a folder that is made for recordings: they are the user's alone."""
TURN = ".sidecars.lock"
SIDECAR_MAX_BYTES = 1 << 20
"""Bytes of a sidecar; it takes a few thousand."""


def check_id(id: str) -> str:
    """`id` when it has the form of an id; raises `RecordingError` for anything else, paths above all."""
    if not is_id(id):
        raise RecordingError(f"{id[:ID_LENGTH]!r} is not the id of a recording")
    return id


def is_id(text: str) -> bool:
    """Whether `text` has the form of an id."""
    return len(text) <= ID_LENGTH and ID.fullmatch(text) is not None


def started(id: str) -> datetime:
    """The time [UTC] that an id begins with; 1970 where its digits are none."""
    try:
        return datetime.strptime(check_id(id)[:15], "%Y%m%d-%H%M%S").replace(tzinfo=UTC)
    except ValueError:
        return datetime.fromtimestamp(0, UTC)


def blank(id: str, actuator: str = "", problem: str = "") -> Recording:
    """What can be said of a recording without its description."""
    return Recording(
        id=id,
        name=id,
        started=started(id),
        seconds=0.0,
        rows=0,
        gaps=0,
        bytes=0,
        actuator=actuator,
        twin=False,
        complete=False,
        problem=problem,
    )


def rrd_path(folder: Path, id: str) -> Path:
    """Where the data of recording `id` is."""
    return folder / f"{check_id(id)}.rrd"


def path(folder: Path, id: str) -> Path:
    """Where its description is."""
    return folder / f"{check_id(id)}.json"


def claim(folder: Path, name: str, started: datetime) -> tuple[str, BinaryIO]:
    """A new id from time and name, its .rrd created and locked: the lock lives as long as the open file."""
    stem = started.astimezone(UTC).strftime("%Y%m%d-%H%M%S")
    slug = "-".join(re.findall(r"[a-z0-9]+", name.lower()))[:40].strip("-")
    base = f"{stem}-{slug}" if slug else stem
    for n in range(1, 1000):
        id = base if n == 1 else f"{base}-{n}"
        try:
            descriptor = os.open(rrd_path(folder, id), os.O_RDWR | os.O_CREAT | os.O_EXCL, PRIVATE)
        except FileExistsError:
            continue
        file = os.fdopen(descriptor, "rb")
        fcntl.flock(file, fcntl.LOCK_EX)
        return id, file
    raise RecordingError(f"no free id for a recording at {stem}")


def lock(path: Path) -> BinaryIO | None:
    """The lock on `path`, or None while a writer holds it; closing the file gives it back."""
    file = open_regular(path)
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        file.close()
        return None
    return file


def is_free(path: Path) -> bool:
    """Whether no writer holds the data in `path`; so it is where there are none, not where no one can tell."""
    try:
        held = lock(path)
    except FileNotFoundError:
        return True
    except OSError:
        return False
    if held:
        held.close()
    return held is not None


@contextmanager
def turn(folder: Path) -> Iterator[None]:
    """One writer of sidecars at a time, whether another thread or another process."""
    with open_lock(folder / TURN) as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def write(folder: Path, recording: Recording) -> Recording:
    """Write the sidecar of `recording` as its writer knows it, and return it: what people edited meanwhile stays."""
    with turn(folder):
        try:
            kept = read(folder, recording.id)
        except RecordingError:
            kept = recording
        edits = {
            "name": kept.name,
            "bookmarks": kept.bookmarks,
            "tags": tuple(dict.fromkeys((*kept.tags, *recording.tags))),
            "notes": kept.notes or recording.notes,
            "starred": kept.starred or recording.starred,
        }
        written = recording.model_copy(update=edits)
        _put(folder, written)
    return written


def update(folder: Path, id: str, **changes: object) -> Recording:
    """Change some fields of the sidecar of `id`, and no others; RecordingError when it cannot be read."""
    return revise(folder, id, lambda found: found.model_copy(update=changes))


def revise(folder: Path, id: str, change: Callable[[Recording], Recording]) -> Recording:
    """Write what `change` makes of the sidecar of `id`, and return it; its errors, and those of `read`."""
    with turn(folder):
        changed = change(read(folder, id))
        _put(folder, changed)
    return changed


def _put(folder: Path, recording: Recording) -> None:
    """Replace the sidecar in one step: a reader sees the old or the new one, whole, after a power cut too."""
    write_whole(path(folder, recording.id), recording.model_dump_json(indent=1))


def read(folder: Path, id: str) -> Recording:
    """The sidecar of `id`; raises `RecordingError` when there is none or it is damaged."""
    try:
        found = Recording.model_validate_json(read_whole(path(folder, id), SIDECAR_MAX_BYTES))
    except FileNotFoundError:
        raise RecordingError(f"there is no recording {id!r}") from None
    except (OSError, ValidationError) as error:
        raise RecordingError(f"the description of recording {id!r} cannot be read: {error}") from error
    if found.id != id:
        raise RecordingError(f"the description of recording {id!r} is that of {found.id!r}")
    return found
