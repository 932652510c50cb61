"""Layouts of plots, per user, in the server's state folder.

A user is a signed-in browser: its session's random id, kept in its cookie. There are no accounts, so two browsers of
one person are two users, and whoever signs in anew after the cookie's week starts with the default layout.
"""

import hashlib
import threading
from pathlib import Path
from typing import Annotated

from pydantic import Field as Bounds
from pydantic import ValidationError

from controller.errors import CommandRefused
from controller.layout import Model
from server.auth import Identity
from server.plots.messages import LayoutName, PlotLayout
from server.settings import write_private

LAYOUTS_MAX = 20
"""Layouts of one user."""
USERS_MAX = 500
"""Users whose layouts are kept: those who saved last."""


class _Kept(Model):
    """One user's file."""

    layouts: Annotated[dict[LayoutName, PlotLayout], Bounds(max_length=LAYOUTS_MAX)]


class Layouts:
    """Reads and writes the layouts in `folder`, one file a user; any thread may."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._lock = threading.Lock()

    def names(self, who: Identity) -> list[str]:
        """Names of the user's layouts."""
        return sorted(self._read(who).layouts)

    def read(self, who: Identity, name: str) -> PlotLayout | None:
        """The layout, None if the user has none of this name."""
        return self._read(who).layouts.get(name)

    def write(self, who: Identity, name: str, layout: PlotLayout) -> None:
        """Keep a layout under a new name or in place of the old one; `CommandRefused` when the user has too many."""
        with self._lock:
            layouts = self._read(who).layouts | {name: layout}
            if len(layouts) > LAYOUTS_MAX:
                raise CommandRefused(f"{LAYOUTS_MAX} layouts are kept: delete one first")
            self._write(who, layouts)

    def delete(self, who: Identity, name: str) -> None:
        """Forget a layout; nothing happens if there is none."""
        with self._lock:
            layouts = self._read(who).layouts
            if name in layouts:
                self._write(who, {other: layout for other, layout in layouts.items() if other != name})

    def _read(self, who: Identity) -> _Kept:
        """What the user kept; nothing where the file is damaged or of another version."""
        try:
            return _Kept.model_validate_json(self._file(who).read_bytes())
        except (OSError, ValidationError):
            return _Kept(layouts={})

    def _write(self, who: Identity, layouts: dict[str, PlotLayout]) -> None:
        try:
            self._folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            write_private(self._file(who), _Kept(layouts=layouts).model_dump_json())
            self._forget_others()
        except OSError as error:
            raise CommandRefused(f"the layout cannot be kept: {error.strerror}") from error

    def _forget_others(self) -> None:
        files = sorted(self._folder.glob("*.json"), key=lambda path: path.stat().st_mtime, reverse=True)
        for path in files[USERS_MAX:]:
            path.unlink(missing_ok=True)

    def _file(self, who: Identity) -> Path:
        return self._folder / f"{hashlib.sha256(who.id.encode()).hexdigest()[:32]}.json"
