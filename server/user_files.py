"""One small file per user, in a folder of the server's state.

A user is a signed-in browser: its session's random id, kept in its cookie. There are no accounts, so two browsers of
one person are two users, and whoever signs in anew after the cookie's week starts with nothing kept.
"""

import hashlib
from pathlib import Path

from controller.errors import CommandRefused
from controller.whole_file import write_whole
from server.auth import Identity

USERS_MAX = 500
"""Users whose files are kept: those who saved last."""


class UserFiles:
    """The files in `folder`; `what` they hold is named where one cannot be written."""

    def __init__(self, folder: Path, what: str) -> None:
        self._folder, self._what = folder, what

    def read(self, who: Identity) -> bytes:
        """The user's file; OSError without one."""
        return self._file(who).read_bytes()

    def write(self, who: Identity, text: str) -> None:
        """Keep the user's file; CommandRefused where the disk does not."""
        try:
            self._folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            write_whole(self._file(who), text)
            self._forget_others()
        except OSError as error:
            raise CommandRefused(f"{self._what} cannot be kept: {error.strerror}") from error

    def forget(self, who: Identity) -> None:
        """Delete the user's file, if there is one."""
        self._file(who).unlink(missing_ok=True)

    def _forget_others(self) -> None:
        files = sorted(self._folder.glob("*.json"), key=lambda path: path.stat().st_mtime, reverse=True)
        for path in files[USERS_MAX:]:
            path.unlink(missing_ok=True)

    def _file(self, who: Identity) -> Path:
        return self._folder / f"{hashlib.sha256(who.id.encode()).hexdigest()[:32]}.json"
