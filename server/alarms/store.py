"""Alarm limits per user, in the server's state folder."""

from pydantic import ValidationError

from server.alarms.messages import AlarmLimits
from server.auth import Identity
from server.user_files import UserFiles


class Alarms:
    """Reads and writes the limits; any thread may."""

    def __init__(self, files: UserFiles) -> None:
        self._files = files

    def read(self, who: Identity) -> AlarmLimits:
        """The user's limits; the defaults where none are kept, or the file is damaged or of another version."""
        try:
            return AlarmLimits.model_validate_json(self._files.read(who))
        except (OSError, ValidationError):
            return AlarmLimits()

    def write(self, who: Identity, limits: AlarmLimits) -> None:
        """Keep the user's limits; CommandRefused where the disk does not."""
        self._files.write(who, limits.model_dump_json())

    def forget(self, who: Identity) -> None:
        """Back to the defaults."""
        self._files.forget(who)
