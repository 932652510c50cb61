"""`python -m tests.recordings.kill_at_random [--times N] [--victim recorder|rig]`: kill with -9 at random moments.

Prints for each kill when it came, how many ticks are lost, and, of a recorder, whether the mended file passes `rerun
rrd verify`; ends with an error when one is not readable, or more than 0.3 s are lost.
"""

import argparse
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from recordings.format import tool
from recordings.read.reader import read_rows
from recordings.store.store import Store
from tests.recordings.kill_rig import kill_rig_once
from tests.recordings.synthetic import telemetry_rows

LOSS_MAX = 300
"""Ticks: 0.3 s."""
MOMENTS = (0.5, 4.0)
"""After the first row [s]."""


def main(victim: str, times: int) -> None:
    """Kill `times` victims and print what each left."""
    losses = []
    for number in range(times):
        wait = random.uniform(*MOMENTS)
        with tempfile.TemporaryDirectory(prefix="tendril-kill-") as folder:
            losses.append(loss := VICTIMS[victim](Path(folder), wait))
        print(f"{number + 1:3}: {victim} killed after {wait:.3f} s, {loss} ticks lost, readable", flush=True)
    print(f"{times} of {times} readable, worst loss {max(losses)} ms")


def kill_once(folder: Path, wait: float) -> int:
    """Ticks that are lost when a recorder is killed `wait` s after its first row; the mended file is checked."""
    handed_over, late = _killed(folder, wait)
    store = Store(folder)
    [id] = store.broken()
    mended = store.repair(id)
    tool.run("rrd", "verify", str(store.path(id)), timeout=60.0)
    found = read_rows(store.path(id))
    np.testing.assert_array_equal(found["p_hat"], telemetry_rows(len(found["tick"]))["p_hat"])
    lost = handed_over - int(found["tick"][-1])
    assert mended.recovered and mended.gaps == 0 and lost <= LOSS_MAX + late, (mended, lost, late)
    return lost


def _killed(folder: Path, wait: float) -> tuple[int, int]:
    """The last tick that a recorder had been given when it was killed, and how late the machine was [ticks]."""
    program = [sys.executable, "-m", "tests.recordings.write_until_killed", str(folder)]
    process = subprocess.Popen(program, stdout=subprocess.PIPE, text=True)
    assert process.stdout
    process.stdout.readline()
    time.sleep(wait)
    process.kill()
    left, _ = process.communicate()
    return last_said(left)


def last_said(text: str) -> tuple[int, int]:
    """Tick and lateness in the last whole line that `write_until_killed` has printed."""
    whole = text[: text.rfind("\n")].splitlines()
    tick, late = whole[-1].split()
    return int(tick), int(late)


def kill_rig(folder: Path, wait: float) -> int:
    """Ticks that are lost when the rig is killed `wait` s after it was recorded, and begins again."""
    left = kill_rig_once(folder, wait)
    assert left.recording.complete and len(left.recording.restarts) == 1 and left.lost <= LOSS_MAX, left
    return left.lost


VICTIMS: dict[str, Callable[[Path, float], int]] = {"recorder": kill_once, "rig": kill_rig}

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--victim", choices=VICTIMS, default="recorder")
    parser.add_argument("--times", type=int, default=20)
    asked = parser.parse_args()
    main(asked.victim, asked.times)
