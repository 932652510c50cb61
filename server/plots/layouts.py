"""Layouts of plots, per user, in the server's state folder."""

import threading
from typing import Annotated

from pydantic import Field as Bounds

from controller.errors import CommandRefused
from controller.schema.layout import Model
from server.access.user_files import UserFiles
from server.http.given import given
from server.http.who import Identity
from server.plots.messages import LayoutName, PlotLayout

LAYOUTS_MAX = 20
"""Layouts of one user."""


class _Kept(Model):
    """One user's file."""

    layouts: Annotated[dict[LayoutName, PlotLayout], Bounds(max_length=LAYOUTS_MAX)]


class Layouts:
    """Reads and writes the layouts, one file a user; any thread may."""

    def __init__(self, files: UserFiles) -> None:
        self._files = files
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
        return self._files.read(who, _Kept.model_validate_json) or _Kept(layouts={})

    def _write(self, who: Identity, layouts: dict[str, PlotLayout]) -> None:
        self._files.write(who, _Kept(layouts=layouts).model_dump_json())


GivenLayouts = Annotated[Layouts, given(Layouts)]
