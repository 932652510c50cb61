"""What we use of rerun that it does not promise to keep (`pyproject.toml` pins its version): its own command-line
program, run quietly: no analytics, nothing written into the user's home; and the end of a stream's memory.
"""

import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import rerun_cli

from controller.errors import RecordingError

PROGRAM = Path(rerun_cli.__file__).with_name("rerun")
"""Itself: `python -m rerun_cli` starts it as a child, which would outlive its parent."""


def release_streams() -> None:
    """Free what rerun keeps of streams that nothing refers to any more: 1 MB each."""
    from rerun_bindings import flush_and_cleanup_orphaned_recordings  # not for a process that only runs the program

    flush_and_cleanup_orphaned_recordings()


def run(*arguments: str, timeout: float) -> None:
    """Run `rerun ARGUMENTS`; raises `RecordingError` with its last words when it fails."""
    with quiet_home() as environment:
        try:
            done = subprocess.run(
                command(*arguments), env=environment, capture_output=True, text=True, timeout=timeout, check=False
            )
        except subprocess.TimeoutExpired:
            raise RecordingError(f"rerun {arguments[0]} took longer than {timeout:g} s") from None
    if done.returncode:
        raise RecordingError(f"rerun {' '.join(arguments[:2])} failed: {(done.stderr or done.stdout).strip()[-400:]}")


def command(*arguments: str) -> list[str]:
    """The program of exactly the installed version, at low priority: a rig may be running beside it."""
    nice = shutil.which("nice")
    return [*([nice, "-n", "19"] if nice else []), str(PROGRAM), *arguments]


@contextmanager
def quiet_home() -> Iterator[dict[str, str]]:
    """Environment with a home of its own (so every run is a "first session") and CI set: both switch analytics off."""
    with tempfile.TemporaryDirectory(prefix="tendril-rerun-") as home:
        own = {name: home for name in ("HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME", "XDG_CACHE_HOME")}
        yield {**os.environ, **own, "CI": "1", "NO_COLOR": "1"}
