"""Two loops on one actuator would fight: a user's second process of the same rig id is refused on this machine."""

import fcntl
import logging
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import BinaryIO

from controller.errors import TendrilError
from controller.realtime.ring import ring_path
from controller.realtime.settings import RigSettings
from controller.system.private_folder import made_private, private_folders, require_own
from controller.system.whole_file import open_lock

log = logging.getLogger(__name__)


@contextmanager
def only_one(settings: RigSettings) -> Iterator[None]:
    """While it lasts, no one else has this rig; TendrilError with who is in the way, or why it cannot be said.

    Locked in every folder that is ours: a process of another session may have its ring in another one.
    """
    with ExitStack() as locks:
        for folder in [settings.folder] if settings.folder else _own_folders():
            locks.enter_context(_locked(settings.rig, folder))
        yield


def _own_folders() -> list[Path]:
    """All that can be made; TendrilError where the first of them, in which the ring would be, is someone else's."""
    found = []
    for folder in private_folders():
        try:
            found.append(made_private(folder))
        except TendrilError:
            if not found:
                raise
        except OSError as error:
            log.warning("%s cannot be used: %s", folder, error)
    if not found:
        raise TendrilError("no folder takes a lock of ours; the log says why")
    return found


def _locked(rig: str, folder: Path) -> BinaryIO:
    path = ring_path(rig, folder).with_suffix(".lock")
    try:
        require_own(path)
        file = open_lock(path)
    except OSError as error:
        raise TendrilError(f"rig {rig!r} cannot be locked: {path}: {error.strerror}; remove it") from error
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        file.close()
        raise TendrilError(f"rig {rig!r} already runs on this machine") from error
    return file
