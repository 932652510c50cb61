"""Which of several servers commands the rig: the first that asks, until it leaves or was silent for SILENT seconds."""

import threading
import time
from collections.abc import Callable

from controller.errors import RigHeld
from controller.link.seal import SealedSession

SILENT = 2.0
"""Silence after which another server may command [s]; the rig itself holds long before, at `server_hold`."""


class Holder:
    """Asked with every sealed message but an E-STOP, which is taken from any server that has the key. Thread safe."""

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._session: SealedSession | None = None
        self._since, self._heard = "", 0.0
        self._lock = threading.Lock()

    def take(self, session: SealedSession) -> None:
        """`session` commands from here on, or still; RigHeld names who does instead, and since when."""
        with self._lock:
            if self._session is not None and session.number != self._session.number:
                if self._now() - self._heard < SILENT:
                    raise RigHeld(
                        f"refused: {self._session.who} commands this rig since {self._since} (its clock); "
                        f"stop that server, or cut it off for {SILENT:g} s"
                    )
                self._session = None
            if self._session is None:
                self._session, self._since = session, time.strftime("%Y-%m-%d %H:%M:%S")
            self._heard = self._now()

    def leave(self, session: SealedSession) -> None:
        """`session` commands no longer, if it did: the next one may at once."""
        with self._lock:
            if self._session is not None and self._session.number == session.number:
                self._session = None
