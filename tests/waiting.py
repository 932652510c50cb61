"""Waiting for what a process or a thread does."""

import time
from collections.abc import Callable
from typing import Any

WAIT_MAX_S = 200.0
"""Seconds before a wait gives up: a machine may be busy, so no test asserts a time."""


def wait_for(what: Callable[[], Any], text: str) -> Any:
    """The first true value of `what()`."""
    end = time.monotonic() + WAIT_MAX_S
    while time.monotonic() < end:
        if found := what():
            return found
        time.sleep(0.01)
    raise AssertionError(f"waited in vain for {text}")
