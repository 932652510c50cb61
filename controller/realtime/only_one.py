"""Two loops on one actuator would fight: a user's second process of the same rig id is refused on this machine."""

import fcntl
from collections.abc import Iterator
from contextlib import contextmanager
from typing import BinaryIO

from controller.errors import TendrilError
from controller.realtime.ring import ring_path, usable_folders
from controller.realtime.settings import RigSettings
from controller.system.private_folder import require_own
from controller.system.whole_file import open_lock


@contextmanager
def only_one(settings: RigSettings) -> Iterator[None]:
    """While it lasts, no one else has this rig; TendrilError with who is in the way, or why it cannot be said."""
    folder = settings.folder or next(usable_folders(), None)
    if folder is None:
        raise TendrilError(f"rig {settings.rig!r} cannot be locked: no folder takes a file of ours; the log says why")
    path = ring_path(settings.rig, folder).with_suffix(".lock")
    try:
        require_own(path)
        file = open_lock(path)
    except OSError as error:
        raise TendrilError(f"rig {settings.rig!r} cannot be locked: {path}: {error.strerror}; remove it") from error
    with file:
        _lock(file, settings.rig)
        yield


def _lock(file: BinaryIO, rig: str) -> None:
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        raise TendrilError(f"rig {rig!r} already runs on this machine") from error
