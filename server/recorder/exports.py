"""Exports on the way to a browser: made in a folder of their own, which goes once they are sent, or no one wants them.

Either in the answer itself, or made first and then fetched by a key, so that a page can show that it waits.
"""

import asyncio
import secrets
import shutil
import tempfile
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from starlette.requests import Request
from starlette.responses import FileResponse
from starlette.types import Receive, Scope, Send

from controller.errors import CommandRefused, ProcessKilled, RecordingError
from controller.schema.layout import Model
from controller.system.scheduler import Scheduler
from recordings.exporting.export import By, Format, export
from recordings.exporting.table import Choice
from server.http.given import given
from server.recorder.folder import RecordingsFolder
from server.recorder.scratch import Scratch, sweep

KEPT = 600.0
"""A file that no one fetches is kept for so long [s]."""
WAITING_MAX = 32
"""Files that may wait to be fetched, of all sessions."""
WAITING_BYTES = 10_000_000_000
"""The same in bytes: with more waiting, no other one is made."""
LEFT_MIN, LEFT_SHARE = 1 << 30, 0.1
"""Room [B] that an export leaves on the disk, or this share of a smaller disk."""
EXPORTS_S = 10.0
"""Between two looks for those that no one has fetched."""
CHECK_S = 0.25
"""Between two looks whether someone still waits, and whether there is room [s]."""
BINARY = "application/octet-stream"
MEDIA = {"csv": "text/csv; charset=utf-8", "parquet": "application/vnd.apache.parquet"}


class ExportMade(Model):
    """An export that can be fetched, once, from /api/exports/{key}."""

    key: str
    name: str
    bytes: int


@dataclass(frozen=True)
class Written:
    """A file in a folder of its own."""

    scratch: Scratch
    path: Path


@dataclass(frozen=True)
class _Waiting:
    file: Written
    since: float
    bytes: int


class Sent(FileResponse):
    """A file that is sent once: `remove` is called in the end, after a refused range and a lost connection too."""

    def __init__(self, file: Path, remove: Callable[[], None]) -> None:
        media = MEDIA.get(file.suffix.removeprefix("."), BINARY)
        super().__init__(file, media_type=media, filename=file.name)
        self._remove = remove

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send it."""
        try:
            await super().__call__(scope, receive, send)
        finally:
            await asyncio.to_thread(self._remove)


class Exports:
    """The files that are being made, wait to be fetched or are being sent."""

    def __init__(self, scheduler: Scheduler) -> None:
        self._scheduler = scheduler
        self._waiting: dict[str, _Waiting] = {}
        self._scratches: set[Scratch] = set()
        self._swept = False

    def look(self) -> None:
        """Forget what waited for too long; at first remove what an earlier process left."""
        if not self._swept:
            self._swept = True
            self._scheduler.begin("the sweep of old exports", asyncio.to_thread(sweep))
        self._forget_old()

    async def make(
        self, folder: RecordingsFolder, request: Request, source: Path, kind: Format, choice: Choice, by: By
    ) -> ExportMade:
        """Have the file made; who hangs up meanwhile cancels it. Errors as of `export`, and of `written`."""
        self._require_few()
        copied = await folder.look(size, source) if kind == "rrd" else 0
        name = f"{source.stem}.{kind}"
        file = await self.written(
            request, name, lambda target: folder.read(export, source, target, kind, choice, by), copied
        )
        key, bytes = secrets.token_urlsafe(12), file.path.stat().st_size
        self._waiting[key] = _Waiting(file, time.monotonic(), bytes)
        return ExportMade(key=key, name=name, bytes=bytes)

    def take(self, key: str) -> Sent:
        """The answer that gives the file to the one who fetches it; RecordingError where it is gone."""
        self._forget_old()
        waiting = self._waiting.pop(key, None)
        if waiting is None:
            raise RecordingError("there is no such export: it was fetched, or is too old")
        return self.sent(waiting.file)

    async def written(
        self, request: Request, name: str, write: Callable[[Path], Awaitable[None]], needs: int = 0
    ) -> Written:
        """What `write` makes under `name`, in a folder of its own; who hangs up meanwhile cancels it.

        `needs` [B] is what it takes at least. CommandRefused where too little room would be left, or is at any time.
        """
        require_room(needs)
        file = self.new(name)
        work = asyncio.ensure_future(write(file.path))
        try:
            while not (await asyncio.wait([work], timeout=CHECK_S))[0]:
                if await request.is_disconnected():
                    raise CommandRefused("the export was cancelled")
                require_room()
            work.result()
        except BaseException as error:
            work.cancel()
            await asyncio.to_thread(self._remove, file.scratch)  # without it no further piece is written
            if isinstance(error, ProcessKilled):
                raise ProcessKilled("the export was killed, perhaps for want of memory: choose fewer signals") from None
            raise
        return file

    def sent(self, file: Written) -> Sent:
        """The answer that gives `file`, which is gone with it."""
        return Sent(file.path, lambda: self._remove(file.scratch))

    def close(self) -> None:
        """Remove all, fetched or not."""
        for scratch in [*self._scratches]:
            self._remove(scratch)

    def new(self, name: str) -> Written:
        """The place of a file called `name`, in a new folder."""
        scratch = Scratch()
        self._scratches.add(scratch)
        return Written(scratch, scratch.path / name)

    def _remove(self, scratch: Scratch) -> None:
        scratch.remove()
        self._scratches.discard(scratch)

    def _forget_old(self) -> None:
        now = time.monotonic()
        for key in [key for key, waiting in self._waiting.items() if now - waiting.since >= KEPT]:
            old = self._waiting.pop(key).file.scratch
            self._scheduler.begin("the removal of an old export", asyncio.to_thread(self._remove, old))

    def _require_few(self) -> None:
        """CommandRefused where as many wait to be fetched as may."""
        until = f"fetch them, or try again later: each goes after {KEPT / 60:g} min"
        if len(self._waiting) >= WAITING_MAX:
            raise CommandRefused(f"{len(self._waiting)} exports wait to be fetched, which is the most: {until}")
        waiting = sum(one.bytes for one in self._waiting.values())
        if waiting > WAITING_BYTES:
            bound = f"the most is {WAITING_BYTES / 1e6:.1f} MB"
            raise CommandRefused(f"exports of {waiting / 1e6:.1f} MB wait to be fetched, {bound}: {until}")


def require_room(needs: int = 0) -> None:
    """CommandRefused where the disk with the exports has too little room for `needs` [B] more."""
    folder = Path(tempfile.gettempdir())
    free, bound = shutil.disk_usage(folder).free, least(folder)
    if free - needs < bound:
        takes = f"it takes {needs >> 20} MiB, " if needs else ""
        left = f"{takes}and an export leaves at least {bound >> 20} MiB (TMPDIR names another folder)"
        raise CommandRefused(f"too little room for the export: {free >> 20} MiB are free in {folder}, {left}")


def least(folder: Path) -> int:
    """Room that an export leaves on the disk of `folder` [B]."""
    return int(min(LEFT_MIN, LEFT_SHARE * shutil.disk_usage(folder).total))


def size(path: Path) -> int:
    """Bytes of the file."""
    return path.stat().st_size


GivenExports = Annotated[Exports, given(Exports)]
