"""The rig's key: 32 secret bytes as base64 in a file of the user's own, the same on both machines of a link."""

import base64
import logging
import os
import secrets
from pathlib import Path

from controller.errors import KeyRefused
from controller.system.whole_file import NotRegular, open_regular, set_aside, write_new

log = logging.getLogger(__name__)

KEY_BYTES = 32
_LONGEST = 200
"""Bytes of the file that are read: a key takes 45."""


class KeyDamaged(KeyRefused):
    """What lies in the key's place is no key."""


def state_folder() -> Path:
    """Folder of the user's own state: TENDRIL_STATE, or by the XDG rule."""
    if own := os.environ.get("TENDRIL_STATE"):
        return Path(own)
    return Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state") / "tendril"


def key_path(rig: str, folder: Path | None = None) -> Path:
    """Where the key of `rig` lies unless someone says otherwise; `folder` None: the user's state folder."""
    return (folder or state_folder()) / f"{rig}.key"


def made_key(path: Path) -> bytes:
    """The key in `path`, made now if there is no such file; errors as of `read_key`."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        write_new(path, base64.b64encode(secrets.token_bytes(KEY_BYTES)) + b"\n")
    except FileExistsError:
        pass
    except OSError as error:
        raise KeyRefused(f"key file {path} cannot be made: {error.strerror}") from error
    return read_key(path)


def mended_key(path: Path) -> bytes:
    """As `made_key`, but a file that holds no key is put aside for a new one. For our own folder only: a file that
    someone named may be anything.
    """
    try:
        return made_key(path)
    except KeyDamaged as error:
        aside = set_aside(path)
        if aside is None:
            raise
        log.warning("%s; it is %s now, and there is a new key: servers elsewhere need a copy of it", error, aside)
        return made_key(path)


def read_key(path: Path) -> bytes:
    """The key in `path`; KeyRefused names the file where it is missing, damaged, or readable by others."""
    try:
        with open_regular(path) as file:
            mode, text = os.fstat(file.fileno()).st_mode, file.read(_LONGEST)
    except FileNotFoundError as error:
        raise KeyRefused(
            f"key file {path} does not exist: copy it from the rig's machine, or name it with --key-file"
        ) from error
    except NotRegular as error:
        raise KeyDamaged(f"key file {path} cannot be read: {error.strerror}") from error
    except OSError as error:
        raise KeyRefused(f"key file {path} cannot be read: {error.strerror}") from error
    if mode & 0o077:
        raise KeyRefused(f"key file {path} has mode {mode & 0o777:04o}, so others can use it: chmod 600 {path}")
    return _decoded(path, text)


def _decoded(path: Path, text: bytes) -> bytes:
    try:
        key = base64.b64decode(text.strip(), validate=True)
    except ValueError:
        key = b""
    if len(key) != KEY_BYTES:
        raise KeyDamaged(f"key file {path} does not hold {KEY_BYTES} bytes in base64: copy it again from the rig")
    return key
