"""Viser's page and files: each is asked for once, made ours, compressed, and kept for everyone.

Viser serves what its wheel holds, the same from start to end. To ask for it at every request, with a client of its own
each time, took the event loop 50 ms and more.
"""

import asyncio
import gzip
import hashlib
from dataclasses import dataclass
from typing import Annotated

import httpx

from server.http.frames import DRAW_SPARINGLY, TELL_ESCAPE, TELL_MOVED, TELL_TOUCHED
from server.http.given import given

HIDE = b"""<style>
[data-floating-window], .mantine-Notifications-root, .mantine-Paper-root[style*=fixed] { display: none !important }
</style>"""
"""Viser offers no way to hide its panel (another one in a narrow frame) and its notices."""
FILES_MAX = 64
"""Files that are kept; viser has fewer."""
_LEVEL = 5
"""Of gzip: more takes longer than it saves on the way."""


@dataclass(frozen=True)
class ViserFile:
    """One file as browsers get it, or what viser says where it has none."""

    status: int
    body: bytes
    """Compressed by gzip."""
    tag: str
    media: str


class ViserFiles:
    """Only the event loop uses it. One client serves for all, from the first file to `close`."""

    def __init__(self, port: int) -> None:
        """`port` is viser's own, on loopback."""
        # No TLS is spoken there; the certificates alone would take 45 ms to read.
        self._client, self._origin = httpx.AsyncClient(trust_env=False, verify=False), f"http://127.0.0.1:{port}"
        self._files: dict[str, asyncio.Task[ViserFile]] = {}

    async def file(self, path: str) -> ViserFile:
        """The file at `path`; who asks while it is being fetched waits for the same one.

        Raises httpx.InvalidURL, or httpx.HTTPError where viser does not answer.
        """
        task = self._files.get(path)
        if task is None:
            task = self._files[path] = asyncio.create_task(self._fetched(path))
            task.add_done_callback(lambda done: self._keep(path, done))
        return await asyncio.shield(task)

    async def close(self) -> None:
        """Ask viser no more."""
        await self._client.aclose()

    async def _fetched(self, path: str) -> ViserFile:
        answer = await self._client.get(f"{self._origin}/{path}", headers={"accept-encoding": "identity"})
        return await asyncio.to_thread(_ours, answer)

    def _keep(self, path: str, done: asyncio.Task[ViserFile]) -> None:
        """Forget what failed or is not there, and of too many the one that came first."""
        if done.cancelled() or done.exception() is not None or done.result().status != 200:
            self._files.pop(path, None)
        elif len(self._files) > FILES_MAX:
            del self._files[next(iter(self._files))]


def _ours(answer: httpx.Response) -> ViserFile:
    ours = HIDE + DRAW_SPARINGLY + TELL_ESCAPE + TELL_MOVED + TELL_TOUCHED
    body = answer.content.replace(b"</head>", ours + b"</head>", 1)
    tag = f'"{hashlib.sha256(body).hexdigest()[:16]}"'
    return ViserFile(answer.status_code, gzip.compress(body, _LEVEL), tag, answer.headers.get("content-type", ""))


GivenViserFiles = Annotated[ViserFiles, given(ViserFiles)]
