"""Only a test that is marked `process` starts a process: `make check` runs all the others between two edits."""

import multiprocessing.util
import sys
import traceback
from typing import Any

STARTS = frozenset({"subprocess.Popen", "os.fork", "os.forkpty", "os.posix_spawn", "os.spawn", "os.system"})
"""Audit events of Python."""
ONCE = ("git", "uname")
"""Asked once in a process for what every file names as its origin, and for the machine, whichever test comes first."""
started: list[str] = []
"""What this test process has started since the running test began."""


def watch() -> None:
    """Note every start of a process from now on."""
    spawn: Any = multiprocessing.util.spawnv_passfds  # type: ignore[attr-defined]

    def noted(path: Any, arguments: Any, files: Any) -> Any:
        started.append(f"multiprocessing: {arguments!r:.200}")
        return spawn(path, arguments, files)

    multiprocessing.util.spawnv_passfds = noted  # type: ignore[attr-defined]
    sys.addaudithook(note)


def note(event: str, given: tuple[Any, ...], starts: frozenset[str] = STARTS) -> None:
    """Of an audit event, where it starts a process. As Python ends, events still come, and globals have gone."""
    if event in starts and given[:1] not in {(one,) for one in ONCE} and not importing():
        started.append(f"{event}: {given!r:.200}")


def importing() -> bool:
    """Whether a library asks for something as it is imported, which is no doing of the test that comes first to it."""
    return any(frame.f_code.co_filename.startswith("<frozen importlib") for frame, _ in traceback.walk_stack(None))
