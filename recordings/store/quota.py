"""Room for recordings: deleted ones go first, then the oldest; the newest, starred and running ones stay."""

import contextlib
import shutil
from pathlib import Path

from controller.errors import TendrilError
from recordings.format.messages import Recording
from recordings.store.store import Store

BYTES = 50_000_000_000
SHARE = 0.8
"""Of the disk."""
FREE_MIN = 1 << 30
"""With less free on the disk [B] nothing deleted is kept."""


def default_quota(folder: Path) -> int:
    """The smaller one of 50 GB and 80 % of the disk that `folder` is on [B]; OSError where there is no such folder."""
    return min(BYTES, int(SHARE * shutil.disk_usage(folder).total))


def enforce(store: Store, most: int) -> list[Recording]:
    """Remove the oldest recordings until the rest takes `most` bytes at most; those removed, oldest first.

    Deleted ones go before any other, the longest deleted first. The newest one stays even where it alone is larger: the
    one who made it wants to see it.
    """
    listed = store.list()
    takes = {recording.id: taken(store, recording) for recording in listed}
    over = clear_bin(store, sum(takes.values()) - most)
    removed = []
    for recording in reversed(listed[1:]):
        if over <= 0:
            break
        with contextlib.suppress(TendrilError):  # starred, or being written
            store.erase(recording.id)
            over -= takes[recording.id]
            removed.append(recording)
    return removed


def taken(store: Store, recording: Recording) -> int:
    """Bytes of its data; of one that is damaged not what its description says, as they may be gone."""
    if not recording.problem:
        return recording.bytes
    try:
        return store.path(recording.id).stat().st_size
    except (OSError, TendrilError):
        return 0


def clear_bin(store: Store, over: int, now: float | None = None) -> int:
    """Remove deleted recordings for good whose time is over `now`, or whose room is needed: so many bytes are `over`
    without those deleted, or the disk is nearly full. Gives the bytes that are over with what is left of them.
    """
    deleted = store.bin.recordings()
    gone = set(store.bin.expired(now))
    nearly_full = bool(deleted) and shutil.disk_usage(store.folder).free < FREE_MIN
    over += sum(recording.bytes for recording in deleted if recording.id not in gone)
    for recording in reversed(deleted):
        if recording.id not in gone and (nearly_full or over > 0):
            gone.add(recording.id)
            over -= recording.bytes
    if gone:
        store.empty_bin(gone)
    return over


def too_large(store: Store, most: int) -> Recording | None:
    """The newest recording, if it takes more than `most` bytes alone."""
    newest = next(iter(store.list()), None)
    return newest if newest and newest.bytes > most else None
