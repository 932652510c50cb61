"""The quick look at a closed recording, kept beside its data, so that no one waits for the data to be read.

A hidden file: the mark of the data it was made from, then the text. It may be deleted at any time.
"""

from contextlib import suppress
from pathlib import Path

from controller.system.whole_file import read_whole, write_whole

Mark = tuple[int, int]
"""Size [B] and time of change [ns]."""


def mark(data: Path) -> Mark:
    """Of the data as they are now."""
    state = data.stat()
    return state.st_size, state.st_mtime_ns


def keep(data: Path, made_from: Mark, text: bytes) -> None:
    """Keep `text`, in one step."""
    write_whole(_file(data), _head(made_from) + text)


def kept(data: Path, now: Mark) -> bytes | None:
    """What was kept of the data, if they have not changed since."""
    try:
        text = read_whole(_file(data))
    except OSError:
        return None
    head = _head(now)
    return text[len(head) :] if text.startswith(head) else None


def forget(data: Path) -> None:
    """Remove it, where there is one."""
    _file(data).unlink(missing_ok=True)


def move(data: Path, to: Path) -> None:
    """Take it along with data that are renamed; where that fails it is made again."""
    with suppress(OSError):
        _file(data).replace(_file(to))


def _head(of: Mark) -> bytes:
    return b"%d %d\n" % of


def _file(data: Path) -> Path:
    return data.with_name(f".{data.stem}.quick")
