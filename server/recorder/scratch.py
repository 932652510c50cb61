"""Folders of files that are on their way out: no longer than the process that made them.

Each holds a lock for as long as its process lives, so that what a killed server left is told from what another one on
this machine still sends.
"""

import fcntl
import os
import shutil
import stat
import tempfile
import time
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO

from controller.system.whole_file import is_regular, open_lock
from recordings.format import sidecar

PREFIX = "tendril-export-"
LOCK = ".lock"
UNLOCKED = 3600.0
"""A folder without a lock is another version's, or about to get one: it is left alone when younger than this [s]."""


class Scratch:
    """A new folder of ours at `path`; OSError where none can be made."""

    def __init__(self) -> None:
        self.path, self._lock = _locked()

    def remove(self) -> None:
        """Remove it with all that it holds, if it is there still. May be called from any thread."""
        shutil.rmtree(self.path, ignore_errors=True)
        self._lock.close()


def sweep() -> None:
    """Remove the folders that killed servers of this user left behind."""
    for folder in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        with suppress(OSError):
            if _is_left(folder):
                shutil.rmtree(folder, ignore_errors=True)


def _locked() -> tuple[Path, BinaryIO]:
    """A folder and the lock in it, made again where a sweep took it before it was locked."""
    while True:
        path = Path(tempfile.mkdtemp(prefix=PREFIX))
        lock = open_lock(path / LOCK)
        fcntl.flock(lock, fcntl.LOCK_EX)
        if is_regular(path / LOCK):
            return path, lock
        lock.close()


def _is_left(folder: Path) -> bool:
    found = folder.lstat()
    if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.geteuid():
        return False
    if not is_regular(folder / LOCK):
        return time.time() - found.st_mtime > UNLOCKED
    return sidecar.is_free(folder / LOCK)
