"""Alarm limits per user, in the server's state folder."""

from concurrent.futures import Future, ThreadPoolExecutor
from typing import Annotated

from server.access.user_files import UserFiles
from server.health.messages import AlarmLimits
from server.http.given import given
from server.http.who import Identity


class Alarms:
    """Reads and writes the limits; any thread may."""

    def __init__(self, files: UserFiles) -> None:
        self._files = files
        self._reader = ThreadPoolExecutor(1, "alarm limits")
        self._known: tuple[str, AlarmLimits] = ("", AlarmLimits())
        self._reading: Future[None] | None = None

    def known(self, who: Identity | None) -> AlarmLimits:
        """The user's limits as they were read last, without a wait; they are read again meanwhile. No one has the
        defaults.
        """
        if who is None:
            return AlarmLimits()
        if self._reading is None or self._reading.done():
            self._reading = self._reader.submit(self._learn, who)
        id, limits = self._known
        return limits if id == who.id else AlarmLimits()

    def _learn(self, who: Identity) -> None:
        self._known = who.id, self.read(who)

    def read(self, who: Identity) -> AlarmLimits:
        """The user's limits; the defaults where none are kept, or the file is damaged or of another version."""
        return self._files.read(who, AlarmLimits.model_validate_json) or AlarmLimits()

    def write(self, who: Identity, limits: AlarmLimits) -> None:
        """Keep the user's limits; CommandRefused where the disk does not."""
        self._files.write(who, limits.model_dump_json())

    def forget(self, who: Identity) -> None:
        """Back to the defaults."""
        self._files.forget(who)


GivenAlarms = Annotated[Alarms, given(Alarms)]
