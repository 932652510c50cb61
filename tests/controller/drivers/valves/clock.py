"""A clock for a peer's watchdog, which stands still unless a test lets it go on: on a busy machine no time is exact."""

import time
from types import ModuleType, SimpleNamespace

import pytest

from tests.waiting import wait_for

LOOKS = 3
"""Of the peer at its clock: the last one is whole after the time has passed."""


class Clock:
    """In the place of `time` in a peer's module."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, module: ModuleType) -> None:
        self._now, self._looks = time.monotonic(), 0
        monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=self._read, monotonic_ns=time.monotonic_ns))

    def pass_by(self, seconds: float) -> None:
        """Let so much time pass at once, and the peer notice."""
        self._now += seconds
        looks = self._looks
        wait_for(lambda: self._looks >= looks + LOOKS, "the peer looks at its clock")

    def _read(self) -> float:
        self._looks += 1
        return self._now
