"""Exports on the way to a browser: made first, then fetched by a key, so that a page can show that it waits."""

import asyncio
import secrets
import shutil
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from starlette.requests import Request

from controller.errors import CommandRefused, ProcessKilled, RecordingError
from controller.schema.layout import Model
from recordings.exporting.export import By, Format, export
from recordings.exporting.table import Choice
from server.http.given import given
from server.recorder.folder import RecordingsFolder

KEPT = 600.0
"""A file that nobody fetches is kept for so long [s]."""
LOOK = 0.25
"""Between two looks whether somebody still waits [s]."""


class ExportMade(Model):
    """An export that can be fetched, once, from /api/exports/{key}."""

    key: str
    name: str
    bytes: int


@dataclass(frozen=True)
class _Made:
    path: Path
    since: float


class Exports:
    """The files that were made and not fetched yet."""

    def __init__(self) -> None:
        self._made: dict[str, _Made] = {}

    async def make(
        self, folder: RecordingsFolder, request: Request, source: Path, kind: Format, choice: Choice, by: By
    ) -> ExportMade:
        """Have the file made; who hangs up meanwhile cancels it. Errors as of `export`."""
        self._forget_old()
        scratch = Path(tempfile.mkdtemp(prefix="tendril-export-"))
        target = scratch / f"{source.stem}.{kind}"
        work = asyncio.ensure_future(folder.read(export, source, target, kind, choice, by))
        try:
            while not (await asyncio.wait([work], timeout=LOOK))[0]:
                if await request.is_disconnected():
                    raise CommandRefused("the export was cancelled")
            work.result()
        except BaseException as error:
            work.cancel()
            shutil.rmtree(scratch, ignore_errors=True)  # without its folder no further piece is written
            if isinstance(error, ProcessKilled):
                raise ProcessKilled("the export was killed, perhaps for want of memory: choose fewer signals") from None
            raise
        key = secrets.token_urlsafe(12)
        self._made[key] = _Made(target, time.monotonic())
        return ExportMade(key=key, name=target.name, bytes=target.stat().st_size)

    def take(self, key: str) -> Path:
        """The file, for the one who fetches it, and removes its folder; RecordingError where it is gone."""
        made = self._made.pop(key, None)
        if made is None:
            raise RecordingError("there is no such export: it was fetched, or is too old")
        return made.path

    def close(self) -> None:
        """Remove what nobody has fetched."""
        self._forget_old(kept=0.0)

    def _forget_old(self, kept: float = KEPT) -> None:
        for key, made in [*self._made.items()]:
            if time.monotonic() - made.since >= kept:
                shutil.rmtree(self._made.pop(key).path.parent, ignore_errors=True)


GivenExports = Annotated[Exports, given(Exports)]
