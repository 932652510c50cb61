"""Tokens that `tendril token new` changes while the server runs: the sessions of the old one end at once."""

import time
from collections.abc import Callable

from controller.errors import ParameterError
from server.auth import Sessions
from server.events import EventLog
from server.lease import OperatorLease
from server.tokens import Secrets, TokenFile

PERIOD = 1.0
"""Seconds between two looks at the file."""


class TokenWatch:
    """Called at every beat; sockets find out for themselves (`Sessions.ended`)."""

    def __init__(
        self, file: TokenFile, sessions: Sessions, kept: Secrets, now: Callable[[], float] = time.monotonic
    ) -> None:
        self._file, self._sessions, self._kept, self._now = file, sessions, kept, now
        self._stamp, self._looked = file.stamp(), now()

    def look(self, lease: OperatorLease, events: EventLog) -> None:
        """Put changed tokens in force; a file that is gone or cannot be read changes nothing."""
        if self._now() - self._looked < PERIOD:
            return
        self._looked, stamp = self._now(), self._file.stamp()
        if stamp in (self._stamp, None):  # a disk that went away must sign out nobody, who may have to press E-STOP
            return
        self._stamp = stamp
        try:
            found = self._file.read()
        except (ParameterError, OSError) as error:
            return events.add(f"the access tokens stay as they were: {error}", "warning")
        if found == self._kept:
            return
        self._kept = found
        self._sessions.use(found)
        events.add("an access token was changed: sessions of the old one have ended", "warning")
        holder = lease.holder
        if holder is not None and not self._sessions.stands(holder):
            lease.release(holder)
