"""What a call costs, without a clock: no machine is too busy for it."""

import gc
import sys
from collections.abc import Callable
from types import FrameType
from typing import Any


def lines_run(call: Callable[[], Any]) -> int:
    """Lines of Python that `call` runs, its callees' too; what C does in one call counts as its line alone.

    No garbage is collected meanwhile: the finalizers of what earlier tests left would be counted as lines of the call.
    """
    count, collecting = 0, gc.isenabled()

    def counted(frame: FrameType, event: str, arg: object) -> Any:
        nonlocal count
        count += event == "line"
        return counted

    before = sys.gettrace()
    gc.disable()
    sys.settrace(counted)
    try:
        call()
    finally:
        sys.settrace(before)
        if collecting:
            gc.enable()
    return count


class Waits:
    """Stands before a socket, or a poll, and keeps for how long it was asked to wait each time [s]."""

    def __init__(self, real: Any) -> None:
        self._real = real
        self.asked: list[float] = []

    def __getattr__(self, name: str) -> Any:
        return getattr(self._real, name)

    def settimeout(self, seconds: float) -> None:
        """As a socket's."""
        self.asked.append(seconds)
        self._real.settimeout(seconds)

    def poll(self, milliseconds: float) -> Any:
        """As a poll's."""
        self.asked.append(1e-3 * milliseconds)
        return self._real.poll(milliseconds)
