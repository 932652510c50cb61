"""Sessions that ended before their cookie did, kept over a restart: a copy of such a cookie is worth nothing.

One session ends by its id: who signed out, or signed in with another role. All sessions of a token end together by a
series, which is part of what signs their cookies: it changes, and the token stays.
"""

import os
import secrets
import threading
from contextlib import suppress
from pathlib import Path

from pydantic import Field as Bounds

from controller.schema.layout import Model
from controller.system.state_file import StateFile
from server.http.who import ROLES, Identity, Role

ENDED_MAX = 10_000
"""Ended sessions of each role that are remembered, the newest, by no clock, which may be set. Who has the token of a
role can push out those of this role alone, and has by the token what they gave.
"""


class EndedOfRole(Model):
    """What ended of the sessions that one role's token opened."""

    series: str = ""
    """Part of what signs the cookies."""
    ids: list[str] = Bounds(default_factory=list)
    """Of the sessions that ended one by one, the newest last."""


class EndedFile(Model):
    """The whole file."""

    operator: EndedOfRole = Bounds(default_factory=EndedOfRole)
    viewer: EndedOfRole = Bounds(default_factory=EndedOfRole)


class EndedSessions:
    """In force at once; `keep`, which any thread may call, puts it on the disk."""

    def __init__(self, path: Path | None = None) -> None:
        """Of the file `path`; None: remembered by this process alone. One that cannot be used ends every session."""
        self._file = StateFile(path, EndedFile.model_validate_json, "all sign in once more") if path else None
        self._lock, self._changes, self._on_disk = threading.Lock(), 0, 0
        kept = self._file.read() if self._file else None
        found: dict[Role, EndedOfRole] = {role: getattr(kept or EndedFile(), role) for role in ROLES}
        self._series = {role: found[role].series for role in ROLES}
        self._ids = {role: dict.fromkeys(found[role].ids) for role in ROLES}
        self.ids = {id for ids in self._ids.values() for id in ids}
        """Of all that ended one by one; looked at with every command, so it is a set and no question."""
        if path and kept is None and os.path.lexists(path):
            for role in ROLES:
                self.end_all(role)
            with suppress(OSError):
                self.keep()

    def series(self, role: Role) -> str:
        """What must be part of the key that signs the cookies of `role`."""
        return self._series[role]

    def end(self, who: Identity) -> None:
        """End the session `who`."""
        self._changes += 1
        ids = self._ids[who.role]
        ids[who.id] = None
        self.ids.add(who.id)
        if len(ids) > ENDED_MAX:
            oldest = next(iter(ids))
            del ids[oldest]
            self.ids.discard(oldest)

    def end_all(self, role: Role) -> None:
        """End all sessions that the token of `role` has opened."""
        self._changes += 1
        self.ids -= self._ids[role].keys()
        self._series[role], self._ids[role] = secrets.token_urlsafe(12), {}

    def keep(self) -> None:
        """Put on the disk what has ended; raises OSError where that fails. It may take as long as the disk does."""
        if self._file is None:
            return
        wanted = self._changes
        with self._lock:
            if self._on_disk >= wanted:  # by who wrote while this waited
                return
            changes = self._changes
            of = {role: EndedOfRole(series=self._series[role], ids=list(self._ids[role])) for role in ROLES}
            self._file.write(EndedFile(**of).model_dump_json())
            self._on_disk = changes
