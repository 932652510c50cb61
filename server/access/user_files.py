"""One small file per user, in a folder of the server's state.

A user is a signed-in browser: the random id of its first session, kept in its cookie. There are no accounts, so two
browsers of one person are two users, and one who signs in again after signing out, or after the cookie's week, starts
with nothing kept.
"""

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from controller.errors import CommandRefused
from controller.system.state_file import StateFile
from controller.system.whole_file import is_regular
from server.http.who import Identity

T = TypeVar("T")

USERS_MAX = 500
"""Users whose files are kept: those who saved last."""


class UserFiles:
    """The files in `folder`; `what` they hold is named where one cannot be written."""

    def __init__(self, folder: Path, what: str) -> None:
        self._folder, self._what = folder, what

    def read(self, who: Identity, parse: Callable[[bytes], T]) -> T | None:
        """What the user's file holds; None where there is none, or none that can be used."""
        return self._state(who, parse).read()

    def write(self, who: Identity, text: str) -> None:
        """Keep the user's file; CommandRefused where the disk does not."""
        try:
            self._folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            self._state(who, bytes).write(text)
            self._forget_others()
        except OSError as error:
            raise CommandRefused(f"{self._what} cannot be kept: {error.strerror}") from error

    def forget(self, who: Identity) -> None:
        """Delete the user's file, if there is one; CommandRefused where the disk does not."""
        try:
            self._file(who).unlink(missing_ok=True)
        except OSError as error:
            raise CommandRefused(f"{self._what} cannot be removed: {error.strerror}") from error

    def _forget_others(self) -> None:
        files = filter(is_regular, self._folder.glob("*.json"))
        for path in sorted(files, key=lambda path: path.lstat().st_mtime, reverse=True)[USERS_MAX:]:
            path.unlink(missing_ok=True)

    def _state(self, who: Identity, parse: Callable[[bytes], T]) -> StateFile[T]:
        return StateFile(self._file(who), parse, f"{self._what} is as at the start")

    def _file(self, who: Identity) -> Path:
        return self._folder / f"{hashlib.sha256((who.user or who.id).encode()).hexdigest()[:32]}.json"
