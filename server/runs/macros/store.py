"""Macros, per user, in the server's state folder."""

import threading
from typing import Annotated

from pydantic import Field as Bounds

from controller.errors import CommandRefused
from controller.schema.layout import Model
from server.access.user_files import UserFiles
from server.http.errors import NotFound
from server.http.given import given
from server.http.who import Identity
from server.runs.macros.messages import Macro, MacroBody, MacroName

MACROS_MAX = 50
"""Macros of one user."""


class _Kept(Model):
    """One user's file."""

    macros: Annotated[dict[MacroName, MacroBody], Bounds(max_length=MACROS_MAX)]


class MacroStore:
    """Reads and writes the macros, one file a user; any thread may."""

    def __init__(self, files: UserFiles) -> None:
        self._files = files
        self._lock = threading.Lock()

    def listed(self, who: Identity) -> list[Macro]:
        """The user's macros, by name."""
        kept = self._read(who)
        return [Macro(name=name, steps=kept[name].steps) for name in sorted(kept, key=str.lower)]

    def read(self, who: Identity, name: str) -> Macro:
        """The macro; NotFound if the user has none of this name."""
        found = self._read(who).get(name)
        if found is None:
            raise NotFound(f"you have no macro named {name}")
        return Macro(name=name, steps=found.steps)

    def write(self, who: Identity, name: str, body: MacroBody) -> None:
        """Keep a macro under a new name or in place of the old one; CommandRefused when the user has too many."""
        with self._lock:
            macros = self._read(who) | {name: body}
            if len(macros) > MACROS_MAX:
                raise CommandRefused(f"{MACROS_MAX} macros are kept: delete one first")
            self._write(who, macros)

    def delete(self, who: Identity, name: str) -> None:
        """Forget a macro; nothing happens if there is none."""
        with self._lock:
            macros = self._read(who)
            if macros.pop(name, None) is not None:
                self._write(who, macros)

    def _read(self, who: Identity) -> dict[str, MacroBody]:
        """What the user kept; nothing where the file is damaged or of another version."""
        kept = self._files.read(who, _Kept.model_validate_json)
        return dict(kept.macros) if kept else {}

    def _write(self, who: Identity, macros: dict[str, MacroBody]) -> None:
        self._files.write(who, _Kept(macros=macros).model_dump_json())


GivenMacroStore = Annotated[MacroStore, given(MacroStore)]
