"""The rig's key: 32 secret bytes as base64 in a file of the user's own, the same on both machines of a link."""

import base64
import os
import secrets
from pathlib import Path

from controller.errors import KeyRefused

KEY_BYTES = 32
_LONGEST = 200
"""Bytes of the file that are read: a key takes 45."""


def state_folder() -> Path:
    """Folder of the user's own state, by the XDG rule."""
    return Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state") / "tendril"


def key_path(rig: str, folder: Path | None = None) -> Path:
    """Where the key of `rig` lies unless somebody says otherwise; `folder` None: the user's state folder."""
    return (folder or state_folder()) / f"{rig}.key"


def made_key(path: Path) -> bytes:
    """The key in `path`, made now if there is no such file; errors as of `read_key`."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:
            file.write(base64.b64encode(secrets.token_bytes(KEY_BYTES)) + b"\n")
    except FileExistsError:
        pass
    except OSError as error:
        raise KeyRefused(f"key file {path} cannot be made: {error.strerror}") from error
    return read_key(path)


def read_key(path: Path) -> bytes:
    """The key in `path`; KeyRefused names the file where it is missing, damaged, or readable by others."""
    try:
        with path.open("rb") as file:
            mode, text = os.fstat(file.fileno()).st_mode, file.read(_LONGEST)
    except FileNotFoundError as error:
        raise KeyRefused(
            f"key file {path} does not exist: copy it from the rig's machine, or name it with --key-file"
        ) from error
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
        raise KeyRefused(f"key file {path} does not hold {KEY_BYTES} bytes in base64: copy it again from the rig")
    return key
