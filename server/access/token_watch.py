"""Tokens that `tendril token new` changes while the server runs: the sessions of the old one end at once.

A file that was changed and cannot be read may have revoked a token, so it is read again every second, and after
CLOSED_AFTER it counts as if it had: who operates does so no more, and everybody may look and press E-STOP until it can
be read. A file that is gone, or whose disk is, revokes nothing: no one can have written into it.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

from controller.errors import ParameterError
from controller.system.thread import SupervisedThread
from server.access.lease import OperatorLease
from server.access.sessions import Sessions
from server.access.tokens import Secrets, TokenFile
from server.log.events import EventLog

READ_S = 1.0
"""Between two looks at the file: a token that is revoked ends so soon."""
IN_FORCE_S = 0.1
"""And what was read is in force so soon, a session that has ended operates so long at most."""
CLOSED_AFTER = 10.0
"""And so soon where the file cannot be read [s]: an editor's save, or a disk that spins up, is over by then."""


@dataclass(frozen=True)
class Read:
    """What one look at the file gave."""

    stamp: object
    found: Secrets | Exception


class TokenWatch:
    """`poll` looks at the file, in a thread: its disk may hang. `look`, a job of the event loop, puts it in force.

    Sockets find out for themselves (`Sessions.ended`).
    """

    def __init__(
        self,
        file: TokenFile,
        sessions: Sessions,
        kept: Secrets,
        lease: OperatorLease,
        events: EventLog,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self._file, self._sessions, self._kept = file, sessions, kept
        self._lease, self._events, self._now = lease, events, now
        self._stamp = file.stamp()
        self._read: Read | None = None
        self._failing: float | None = None
        self.worker = SupervisedThread("access tokens", self._run)

    def start(self) -> None:
        """Look at the file once a second from now on."""
        self.worker.start()

    def stop(self) -> None:
        """Look no more."""
        self.worker.stop(0.0)

    def poll(self) -> None:
        """Read the file if it has changed since it was last read whole; it may take as long as the disk does."""
        stamp = self._file.stamp()
        if stamp in (self._stamp, None):  # a disk that went away must sign out no one, who may have to press E-STOP
            return
        try:
            found: Secrets | Exception = self._file.read()
        except (ParameterError, OSError) as error:
            found = error
        self._read = Read(stamp, found)

    def look(self) -> None:
        """Put in force what was read last."""
        read, self._read = self._read, None
        if read is not None and isinstance(read.found, Secrets):
            self._stamp, self._failing = read.stamp, None
            self._use(read.found)
        elif read is not None and self._failing is None:
            self._failing = self._now()
            until = f"no one operates from {CLOSED_AFTER:g} s on, until they can be read"
            self._events.add(f"the access tokens stay as they were: {read.found}; {until}", "warning")
        if self._failing is not None and not self._sessions.closed and self._now() - self._failing >= CLOSED_AFTER:
            self._sessions.closed = True
            self._events.add(
                "the access tokens cannot be read: no one operates, all may look and press E-STOP", "error"
            )
        holder = self._lease.holder
        if holder is not None and not self._sessions.stands(holder):
            self._lease.release(holder, "the access tokens cannot be read")

    def _use(self, found: Secrets) -> None:
        if self._sessions.closed:
            self._sessions.closed = False
            self._events.add("the access tokens can be read again", "warning")
        if found != self._kept:
            self._kept = found
            self._sessions.use(found)
            self._events.add("an access token was changed: sessions of the old one have ended", "warning")

    def _run(self) -> None:
        while not self.worker.wait(READ_S):
            self.poll()
