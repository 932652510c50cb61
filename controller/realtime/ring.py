"""Telemetry ring in shared memory: one writer that never waits, any number of readers, readable after a crash.

It lies in a folder of this user alone, and none but this user may read or write it.

The file holds HEADER_WORDS words of 8 bytes, then `capacity` rows. Each word of the header has one writer: HEAD,
LOOP_NS, GRID_NS and STEPPED the loop, PUMP_NS and STOP the main thread, PAUSED and STEPS the link, the BASELINE words
the baseline thread.
"""

import logging
import os
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np

from controller.arrays import Words
from controller.errors import LayoutMismatch, RigUnreachable, TendrilError
from controller.realtime.compiled import compiled, fence_acquire, fence_release, load_acquire, store_release
from controller.schema.layout import layout_hash, record_dtype, require_same_layout
from controller.schema.messages import Command, Telemetry
from controller.system.private_folder import is_private, made_private, private_folders, require_own
from controller.system.whole_file import is_regular, open_new, open_regular, open_update, set_aside

log = logging.getLogger(__name__)

CAPACITY = 32768
"""Rows: 32 s at 1 kHz. With the one before, two rings fit the 64 MB of a container's /dev/shm."""
ROW = record_dtype(Telemetry)
ROW_WORDS = ROW.itemsize // 8
HEADER_WORDS = 64
MAGIC = int.from_bytes(b"TENDRIL1", "little")

MAGIC_WORD, LAYOUT_WORD, BOOT_WORD, CAPACITY_WORD, PROCESS_WORD = range(5)
# Written at different rates by different threads, so each on a cache line (8 words) of its own.
HEAD, LOOP_NS, PUMP_NS, STOP, GRID_NS, BASELINE_TICKS = 8, 16, 24, 32, 40, 48
BASELINE_LOST = BASELINE_TICKS + 1
PAUSED, STEPS, STEPPED = 25, 26, 17
"""1: the loop stands between two ticks, until it has taken STEPS steps in all; STEPPED counts those it took."""


@compiled
def ring_push(header: Words, rows: Words, row: Words) -> None:
    """Append the words of one row."""
    count = header[HEAD]
    fence_release()
    slot = count % rows.shape[0]
    for i in range(row.shape[0]):
        rows[slot, i] = row[i]
    store_release(header, HEAD, count + 1)


@compiled
def ring_read(header: Words, rows: Words, first: int, out: Words) -> tuple[int, int]:
    """Copy rows [first, head) into out, oldest first; returns (index of the first row copied, rows copied).

    What was overwritten before or during the copy is left out: then the index returned is above `first`.
    """
    capacity = rows.shape[0]
    head = load_acquire(header, HEAD)
    start = max(0, first, head - capacity + 1)
    count = max(0, min(head - start, out.shape[0]))
    for i in range(count):
        out[i, :] = rows[(start + i) % capacity, :]
    fence_acquire()
    overwritten = load_acquire(header, HEAD) - capacity + 1 - start
    torn = min(max(0, overwritten), count)
    if torn > 0:
        for i in range(count - torn):
            out[i, :] = out[i + torn, :]
    return start + torn, count - torn


class Ring:
    """A mapped ring file: `header` int64 (HEADER_WORDS,), `rows` int64 (capacity, ROW_WORDS)."""

    def __init__(self, path: Path, *, writable: bool) -> None:
        """Map an existing ring; raises RigUnreachable without one, LayoutMismatch if it is not of our layout."""
        try:
            with open_update(path) if writable else open_regular(path) as file:
                memory = np.memmap(file, np.int64, "r+" if writable else "r").view(np.ndarray)
        except (OSError, ValueError) as error:
            raise RigUnreachable(f"no telemetry ring at {path}: {error}") from error
        _check(path, memory)
        self.path = path
        self.header = memory[:HEADER_WORDS]
        self.rows = memory[HEADER_WORDS:].reshape(-1, ROW_WORDS)

    @property
    def boot(self) -> int:
        """Boot id of the rig process that writes it."""
        return int(self.header[BOOT_WORD])

    @property
    def head(self) -> int:
        """Rows written since the start."""
        return int(self.header[HEAD])

    def read(self, first: int, count: int) -> tuple[int, np.ndarray]:
        """Up to `count` Telemetry rows from index `first` on, and the index of the first one returned."""
        ready = max(0, min(count, self.head - first, len(self.rows)))
        out = np.empty((ready, ROW_WORDS), np.int64)
        start, copied = ring_read(self.header, self.rows, first, out)
        return start, np.ndarray(copied, ROW, out)  # as a view, but a view of records is checked for 50 us

    def newest(self) -> np.void | None:
        """The last Telemetry row, or None while there is none."""
        for _ in range(10):
            rows = self.read(self.head - 1, 1)[1]
            if len(rows):
                return rows[0]  # type: ignore[no-any-return]
        return None


def create_ring(rig: str, boot: int, folder: Path | None = None, capacity: int = CAPACITY) -> Ring:
    """A new ring file of `rig`, all pages present, moved to its final name; the one before is kept as `.last`.

    TendrilError where there is no room for it, or what has its name is someone else's.
    """
    size = 8 * HEADER_WORDS + capacity * ROW.itemsize
    fresh = _reserve([folder] if folder else usable_folders(), rig, size)
    with open_update(fresh) as file:
        header = np.memmap(file, np.int64, "r+", shape=(HEADER_WORDS,))
    header[LAYOUT_WORD : LAYOUT_WORD + 1].view(np.uint64)[0] = int(layout_hash(Command, Telemetry), 16)
    header[[MAGIC_WORD, BOOT_WORD, CAPACITY_WORD, PROCESS_WORD]] = MAGIC, boot, capacity, os.getpid()
    path = ring_path(rig, fresh.parent)
    _make_way(path.with_suffix(".last"))
    if _make_way(path):
        path.replace(path.with_suffix(".last"))
    fresh.replace(path)
    ring = Ring(path, writable=True)
    ring.rows[:] = 0  # touches every page: the loop must not meet a page fault
    return ring


def find_ring(rig: str, folder: Path | None = None) -> Ring:
    """The ring of the newest boot of `rig` on this machine, for reading."""
    places = [folder] if folder else [place for place in private_folders() if is_private(place)]
    paths = [ring_path(rig, place) for place in places]
    found = {path: written for path in paths if (written := _written(path)) is not None}
    if not found:
        raise RigUnreachable(f"no telemetry ring of rig {rig!r} on this machine")
    return Ring(max(found, key=found.__getitem__), writable=False)


def remove_rings(rig: str, folder: Path | None = None) -> None:
    """Delete the rings of `rig`, its flight recorder included: for a rig that is not to come back."""
    for place in [folder] if folder else filter(is_private, private_folders()):
        for suffix in (".ring", ".last", ".lock"):
            ring_path(rig, place).with_suffix(suffix).unlink(missing_ok=True)


def ring_path(rig: str, folder: Path) -> Path:
    """Where the current ring of `rig` lies inside `folder`."""
    return folder / f"tendril-{rig}.ring"


def usable_folders() -> Iterator[Path]:
    """Places for a ring, best first, each made as it is asked for; TendrilError where one is not ours alone."""
    for folder in private_folders():
        try:
            yield made_private(folder)
        except OSError as error:
            log.warning("%s cannot be used: %s", folder, error)


def _written(path: Path) -> float | None:
    """When it was, or None where there is no such file, be it since a moment ago."""
    try:
        return path.stat().st_mtime
    except OSError:
        return None


def _reserve(folders: Iterable[Path], rig: str, size: int) -> Path:
    """An empty file of `size` bytes in the first folder with room for it: room found missing later would be a crash."""
    tried = []
    for folder in folders:
        path = ring_path(rig, folder).with_suffix(".new")
        if _make_way(path):
            path.unlink()
        try:
            with open_new(path) as file:
                os.posix_fallocate(file.fileno(), 0, size)
            return path
        except OSError:
            with suppress(OSError):
                path.unlink()
        tried.append(str(folder))
    raise TendrilError(f"no room for {size / 1e6:.0f} MB of telemetry ring in {', '.join(tried)}")


def _make_way(path: Path) -> bool:
    """Whether a file of ours is at `path`; what is none is put aside. TendrilError where it is someone else's."""
    require_own(path)
    if not is_regular(path) and os.path.lexists(path):
        aside = set_aside(path)
        log.warning("%s is not a regular file%s", path, f": it is {aside} now" if aside else "")
    return is_regular(path)


def _check(path: Path, memory: Words) -> None:
    if len(memory) < HEADER_WORDS or memory[MAGIC_WORD] != MAGIC:
        raise LayoutMismatch(f"{path} is not a telemetry ring")
    require_same_layout(
        layout_hash(Command, Telemetry), f"{memory[LAYOUT_WORD : LAYOUT_WORD + 1].view(np.uint64)[0]:016x}"
    )
