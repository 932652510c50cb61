"""Work in a process of its own ends with the process that asked for it, and so does what it runs."""

import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import psutil

ASK = """
import sys
from pathlib import Path
from recordings.store.apart import apart
from tests.recordings.test_apart import run_for_ever
apart(run_for_ever, Path(sys.argv[1]))
"""
PROGRAM = "import os, sys, time; open(sys.argv[1], 'w').write(str(os.getpid())); time.sleep(600)"


def run_for_ever(note: Path) -> None:
    """Runs a program that never ends; `note` is written once it runs."""
    subprocess.run([sys.executable, "-c", PROGRAM, str(note)], check=False)


def test_a_program_that_a_killed_server_had_started_is_ended(tmp_path: Path) -> None:
    note = tmp_path / "note"
    asker = subprocess.Popen([sys.executable, "-c", ASK, str(note)], cwd=Path(__file__).parents[2])
    until(lambda: note.exists() and note.read_text() != "")
    program = int(note.read_text())
    assert psutil.pid_exists(program)
    asker.kill()
    asker.wait()
    until(lambda: not psutil.pid_exists(program))


def until(condition: Callable[[], bool]) -> None:
    """Wait for it, for a minute at most."""
    end = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)
