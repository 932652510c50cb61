"""Room for recordings: the oldest go into the bin, and nothing is erased to make room."""

from pathlib import Path
from shutil import disk_usage
from typing import NamedTuple

from controller.errors import TendrilError
from recordings.format import sidecar
from recordings.format.messages import Recording
from recordings.store.store import Store

BYTES = 50_000_000_000
SHARE = 0.8
"""Of the disk."""
BLOCK_BYTES = 512
"""Unit of `st_blocks`, whatever the blocks of the disk are."""


class Enforced(NamedTuple):
    """What came of a look at the quota."""

    moved: list[Recording]
    """Into the bin, oldest first."""
    over: int
    """Bytes beyond the quota that stay: nothing that may go would help."""


def default_quota(folder: Path) -> int:
    """The smaller one of 50 GB and 80 % of the disk that `folder` is on [B]; OSError where there is no such folder."""
    return min(BYTES, int(SHARE * disk_usage(folder).total))


def enforce(store: Store, most: int) -> Enforced:
    """Move the oldest recordings into the bin until the rest takes `most` bytes at most.

    What cannot be read counts nothing and stays: a file that someone puts there displaces no recording. The newest,
    starred and running ones stay, and where the others are not enough, all do.
    """
    readable = [one for one in store.list() if not one.problem]
    takes = {one.id: bytes_on_disk(store, one.id) for one in readable}
    over = sum(takes.values()) - most
    may_go = [one for one in reversed(readable[1:]) if takes[one.id] and _may_go(store, one)]
    if over > sum(takes[one.id] for one in may_go):
        return Enforced([], over)
    moved = []
    for one in may_go:
        if over <= 0:
            break
        try:
            store.remove(one.id)
        except TendrilError:  # starred this moment, or the folder takes no change
            continue
        over -= takes[one.id]
        moved.append(one)
    return Enforced(moved, max(0, over))


def bytes_on_disk(store: Store, id: str) -> int:
    """Bytes of the blocks that the data of `id` take: of a file with holes, far fewer than its size."""
    try:
        return store.path(id).lstat().st_blocks * BLOCK_BYTES
    except (OSError, TendrilError):
        return 0


def _may_go(store: Store, recording: Recording) -> bool:
    return not recording.starred and sidecar.is_free(sidecar.rrd_path(store.folder, recording.id))
