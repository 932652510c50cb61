"""`python -m server.faults.inside MODULE ARGUMENT`: run a program in which SIGUSR1 breaks something from inside.

What is to be broken stands as JSON in the file that the environment names as ORDER.
"""

import ctypes
import json
import os
import runpy
import signal
import sys
import time
from pathlib import Path

ORDER = "FAULT_ORDER"


def act(*_: object) -> None:
    """Do what the order says: `hold_gil` for so many seconds, `step_clock` by so many."""
    order = json.loads(Path(os.environ[ORDER]).read_text())
    if "hold_gil" in order:
        ctypes.PyDLL(None).usleep(int(order["hold_gil"] * 1e6))  # PyDLL keeps the GIL, unlike CDLL
    if "step_clock" in order:
        step_clock(order["step_clock"])


def step_clock(seconds: float) -> None:
    """Step Python's wall clock; the monotonic one stays as it is."""
    now, now_ns = time.time, time.time_ns
    time.time = lambda: now() + seconds
    time.time_ns = lambda: now_ns() + int(seconds * 1e9)


if __name__ == "__main__":
    signal.signal(signal.SIGUSR1, act)
    del sys.argv[0]
    runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
