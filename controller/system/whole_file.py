"""Files that a reader finds whole or not at all, in folders where anything else may lie, too.

Written beside their place, put on the disk, renamed into it. Read only where they are regular files in that very
folder: a pipe would hold up its reader for ever, and a link may lead anywhere.
"""

import errno
import os
import secrets
import stat
import threading
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO

PRIVATE = 0o600
"""Mode of a file that is the user's alone."""
READ_MOST = 32 << 20
"""Bytes of a file that is read at once: more than any that we write."""
_KINDS = {stat.S_IFDIR: "a folder", stat.S_IFIFO: "a pipe", stat.S_IFLNK: "a link", stat.S_IFSOCK: "a socket"}
_NO_SYNC = (errno.EINVAL, errno.ENOTSUP)
"""What file systems say that cannot put a folder on the disk."""


class NotRegular(OSError):
    """What has the name of a file is something else."""


def write_whole(path: Path, content: bytes | str, lasting: bool = True) -> None:
    """Put `content` (text as UTF-8) at `path` in one step, with the mode PRIVATE.

    Raises OSError, and then the old file is there, or the new.

    `lasting`: the file is on the disk before the rename and the rename before the end, so that a power cut leaves the
    old file or the new one, and after the end the new one. That waits for the disk: leave it out only for what no other
    start reads.
    """
    data = content.encode() if isinstance(content, str) else content
    draft = path.with_name(f"{path.name}.{os.getpid()}-{threading.get_native_id()}")
    try:
        _fill(draft, data, lasting)
        draft.replace(path)
    except OSError:
        with suppress(OSError):
            draft.unlink(missing_ok=True)
        raise
    if lasting:
        sync_folder(path.parent)


def write_new(path: Path, content: bytes) -> None:
    """As `write_whole`, lasting and private, but FileExistsError where anything is at `path` already."""
    draft = path.with_name(f"{path.name}.{os.getpid()}-{secrets.token_hex(4)}")
    try:
        _fill(draft, content, lasting=True)
        os.link(draft, path)
    finally:
        draft.unlink(missing_ok=True)
    sync_folder(path.parent)


def open_regular(path: Path) -> BinaryIO:
    """`path` opened to be read; OSError as ever, NotRegular where it is a folder, a pipe, a link or the like."""
    return os.fdopen(_opened(path, os.O_RDONLY), "rb")


def open_update(path: Path) -> BinaryIO:
    """`path` opened to be read and changed in place; errors as of `open_regular`."""
    return os.fdopen(_opened(path, os.O_RDWR), "r+b")


def open_new(path: Path) -> BinaryIO:
    """The private file `path`, made to be read and changed; FileExistsError where anything is there already."""
    return os.fdopen(_opened(path, os.O_RDWR | os.O_CREAT | os.O_EXCL), "r+b")


def open_append(path: Path) -> BinaryIO:
    """The regular file `path`, made private where it is missing, to be added to; errors as of `open_regular`."""
    return os.fdopen(_opened(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND), "ab")


def open_lock(path: Path) -> BinaryIO:
    """`path`, made where it is missing, for a lock on it; nothing is written into it. Errors as of `open_regular`."""
    return os.fdopen(_opened(path, os.O_RDWR | os.O_CREAT, PRIVATE), "rb")


def read_whole(path: Path, most: int = READ_MOST) -> bytes:
    """All of the regular file `path`; OSError where it has more than `most` bytes, or as of `open_regular`."""
    with open_regular(path) as file:
        data = file.read(most + 1)
    if len(data) > most:
        raise OSError(errno.EFBIG, f"it has more than {most} bytes", str(path))
    return data


def is_regular(path: Path) -> bool:
    """Whether `path` itself is a regular file; not so where it is missing or cannot be looked at."""
    try:
        return stat.S_ISREG(path.lstat().st_mode)
    except OSError:
        return False


def set_aside(path: Path) -> Path | None:
    """Rename what lies at `path` and cannot be used, so that a good file can take its place; None where that fails."""
    aside = path.with_name(f"{path.name}.damaged-{secrets.token_hex(3)}")
    try:
        path.rename(aside)
    except OSError:
        return None
    return aside


def sync_file(path: Path) -> None:
    """Put the data of the regular file `path` on the disk, whichever process wrote them."""
    with open_regular(path) as file:
        os.fsync(file.fileno())


def sync_folder(folder: Path) -> None:
    """Put the names in `folder` on the disk: new files, renamed ones and those that are gone."""
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in _NO_SYNC:
            raise
    finally:
        os.close(descriptor)


def _fill(draft: Path, data: bytes, lasting: bool) -> None:
    with os.fdopen(_opened(draft, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), "wb") as file:
        file.write(data)
        if lasting:
            file.flush()
            os.fsync(file.fileno())


def _opened(path: Path, flags: int, mode: int = PRIVATE) -> int:
    """Never waits for the other end of a pipe, and never follows a link."""
    try:
        descriptor = os.open(path, flags | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC, mode)
    except OSError as error:
        if error.errno in (errno.ELOOP, errno.ENXIO, errno.EISDIR):
            raise _odd(path, path.lstat().st_mode) from error
        raise
    found = os.fstat(descriptor).st_mode
    if stat.S_ISREG(found):
        return descriptor
    os.close(descriptor)
    raise _odd(path, found)


def _odd(path: Path, mode: int) -> NotRegular:
    kind = _KINDS.get(stat.S_IFMT(mode), "a device")
    return NotRegular(errno.EINVAL, f"it is {kind}, not a regular file", str(path))
