"""Room for recordings: the oldest go when all together take too much; the newest, starred and running ones stay."""

import contextlib
import shutil
from pathlib import Path

from controller.errors import TendrilError
from recordings.format.messages import Recording
from recordings.store.store import Store

BYTES = 50_000_000_000
SHARE = 0.8
"""Of the disk."""


def default_quota(folder: Path) -> int:
    """The smaller one of 50 GB and 80 % of the disk that `folder` is on [B]; OSError where there is no such folder."""
    return min(BYTES, int(SHARE * shutil.disk_usage(folder).total))


def enforce(store: Store, most: int) -> list[Recording]:
    """Remove the oldest recordings until the rest takes `most` bytes at most; those removed, oldest first.

    The newest one stays even where it alone is larger: the one who made it wants to see it.
    """
    listed = store.list()
    over = sum(recording.bytes for recording in listed) - most
    removed = []
    for recording in reversed(listed[1:]):
        if over <= 0:
            break
        with contextlib.suppress(TendrilError):  # starred, or being written
            store.remove(recording.id)
            over -= recording.bytes
            removed.append(recording)
    return removed


def too_large(store: Store, most: int) -> Recording | None:
    """The newest recording, if it takes more than `most` bytes alone."""
    newest = next(iter(store.list()), None)
    return newest if newest and newest.bytes > most else None
