"""What takes two cores by itself runs one at a time, whichever worker of pytest has it."""

import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from controller.system.whole_file import open_lock

VIRTUAL_RIG = "virtual-rig"
"""Rig, server and devices, each with a loop that keeps time."""


@contextmanager
def turn(name: str) -> Iterator[None]:
    """Wait until no other test has its turn of this name; the kernel ends a turn with its process."""
    with open_lock(Path(tempfile.gettempdir(), f"tendril-tests-{os.getuid()}-{name}")) as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield
