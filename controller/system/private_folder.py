"""Folders of this user alone, for what its processes share, on a machine that others use, too.

Shared memory and the folder of temporary files are open to everyone: who is first has a name there. So what lies there
lies in a folder that only its owner may enter, and that is looked at before it is used.
"""

import os
import pwd
import stat
import tempfile
from contextlib import suppress
from pathlib import Path

from controller.errors import TendrilError

FOLDER_MODE = 0o700
OTHERS = 0o077
"""Rights of group and others."""
SHARED_MEMORY = Path("/dev/shm")
SESSIONS = Path("/run/user")
"""Where the system keeps a private folder for each user who is signed in."""


def private_folders() -> list[Path]:
    """Where ours may be, best first: in the session's folder, in shared memory, among temporary files. None is made."""
    user = os.geteuid()
    sessions = [Path(os.environ.get("XDG_RUNTIME_DIR", "")), SESSIONS / str(user)]
    sessions = [place for place in sessions if place.is_absolute() and is_private(place)]
    everyones = [place for place in (SHARED_MEMORY, Path(tempfile.gettempdir())) if os.access(place, os.W_OK)]
    return [*(place / "tendril" for place in sessions[:1]), *(place / f"tendril-{user}" for place in everyones)]


def made_private(folder: Path) -> Path:
    """`folder`, made where it is missing; TendrilError where it is not ours alone, OSError where it cannot be made."""
    with suppress(FileExistsError):
        folder.mkdir(FOLDER_MODE)
    if why := _why_not_private(folder):
        remedy = "remove it, as its owner or as root, or set XDG_RUNTIME_DIR to a folder of yours with mode 0700"
        raise TendrilError(f"{folder} {why}, so what others do there cannot be trusted: {remedy}")
    return folder


def is_private(folder: Path) -> bool:
    """Whether `folder` is there, no link, ours, and closed to all others."""
    try:
        return not _why_not_private(folder)
    except OSError:
        return False


def require_own(path: Path) -> None:
    """TendrilError where what lies at `path`, if anything does, is someone else's."""
    with suppress(FileNotFoundError):
        if path.lstat().st_uid != os.geteuid():
            raise TendrilError(f"{path} belongs to {owner(path)}: remove it, as its owner or as root")


def owner(path: Path) -> str:
    """Whose `path` is, in words; OSError where nothing is there."""
    uid = path.lstat().st_uid
    try:
        return f"user {pwd.getpwuid(uid).pw_name} (uid {uid})"
    except KeyError:
        return f"uid {uid}"


def _why_not_private(folder: Path) -> str:
    found = folder.lstat()
    if found.st_uid != os.geteuid():
        return f"belongs to {owner(folder)}"
    if not stat.S_ISDIR(found.st_mode):
        return "is no folder"
    if found.st_mode & OTHERS:
        return f"may be entered by others (mode {stat.S_IMODE(found.st_mode):04o})"
    return ""
