"""`python -m server.campaign.inside MODULE ARGUMENT`: run a program in which SIGUSR1 breaks something from inside.

What is to be broken stands as JSON in the file that the environment names as ORDER.
"""

import contextlib
import ctypes
import json
import os
import runpy
import signal
import sys
import time
from functools import reduce
from pathlib import Path
from typing import Any

ORDER = "FAULT_ORDER"
NAP = 0.01
"""Between two looks at it while something hangs [s]."""


def act(*_: object) -> None:
    """Do what the order says: `hold_gil` for a number of seconds, `step_clock` by one; `stand` still, which the event
    loop's own thread does; let `calls` ("module:Class.method") for `seconds` do `how`: fail, hang, or end their thread;
    only those with `argument`, part of its text, if that is named. What hangs goes on once the order is another. Calls
    that this process does not have are another's.
    """
    order = given_order()
    if "hold_gil" in order:
        ctypes.PyDLL(None).usleep(int(order["hold_gil"] * 1e6))  # PyDLL keeps the GIL, unlike CDLL
    if "stand" in order:
        time.sleep(order["stand"])
    for name in order.get("calls", ()):
        if name.split(":")[0] in sys.modules:
            break_calls(name, order)
    if "step_clock" in order:
        step_clock(order["step_clock"])


def given_order() -> dict[str, Any]:
    """What the file says now; empty once it was taken back, or while another one is written."""
    with contextlib.suppress(FileNotFoundError, ValueError):
        found: dict[str, Any] = json.loads(Path(os.environ[ORDER]).read_text())
        return found
    return {}


def break_calls(name: str, order: dict[str, Any]) -> None:
    """From now on calls of `name` do as the order says, for so long; to `end` a thread is done once."""
    how, argument, until = order["how"], order.get("argument", ""), time.monotonic() + order["seconds"]
    module, path = name.split(":")
    *owners, last = path.split(".")
    owner = reduce(getattr, owners, sys.modules[module])
    call, ended = getattr(owner, last), False

    def broken(*given: object, **named: object) -> object:
        nonlocal ended
        if time.monotonic() > until or (argument and argument not in repr((given, named))):
            return call(*given, **named)
        if how == "hang":
            while time.monotonic() < until and given_order() == order:
                time.sleep(NAP)
        elif how == "fail":
            raise OSError(f"{last} was broken on purpose")
        elif not ended:
            ended = True
            raise SystemExit("ended on purpose")
        return call(*given, **named)

    setattr(owner, last, broken)


def step_clock(seconds: float) -> None:
    """Step Python's wall clock; the monotonic one stays as it is."""
    now, now_ns = time.time, time.time_ns
    time.time = lambda: now() + seconds
    time.time_ns = lambda: now_ns() + int(seconds * 1e9)


if __name__ == "__main__":
    signal.signal(signal.SIGUSR1, act)
    del sys.argv[0]
    if sys.argv[0] == "server.app":  # so does its recorder
        from server.recorder import client

        client.PROGRAM = ("server.campaign.inside", *client.PROGRAM)
    runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
