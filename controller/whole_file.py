"""A file that a reader finds whole or not at all: written beside its place, then renamed into it."""

import os
import threading
from pathlib import Path

PRIVATE = 0o600
"""Mode of a file that is the user's alone."""
SHARED = 0o644


def write_whole(path: Path, content: bytes | str, mode: int = PRIVATE, lasting: bool = True) -> None:
    """Put `content` (text as UTF-8) at `path` in one step; raises OSError, and then all is as it was.

    `lasting`: on the disk before the rename, so that a power cut leaves the old file or the new one. That waits for the
    disk: leave it out for what can be made again, or is written every second.
    """
    data = content.encode() if isinstance(content, str) else content
    draft = path.with_name(f"{path.name}.{os.getpid()}-{threading.get_native_id()}")
    try:
        with os.fdopen(os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, mode), "wb") as file:
            file.write(data)
            if lasting:
                file.flush()
                os.fsync(file.fileno())
        draft.replace(path)
    except OSError:
        draft.unlink(missing_ok=True)
        raise
