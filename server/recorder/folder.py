"""The folder of recordings as routes ask it: in threads of its own, and with a bound on the wait.

What reads whole recordings is done by a process of its own, at low priority: the server goes on serving, and its memory
stays as it is.
"""

import asyncio
from collections.abc import Callable, Hashable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Annotated, Any, ParamSpec, TypeVar

from controller.errors import TendrilError
from controller.system.work_process import WorkProcess
from recordings.store.store import Store
from server.http.given import given

P = ParamSpec("P")
T = TypeVar("T")
LOOKERS = 4
"""Threads that may wait for the folder, and as many that may wait for the reader."""
LOOK_TIMEOUT = 30.0
"""Longest wait for an answer of it [s]: a long recording's quick look takes seconds."""
NAME, NICE = "reading recordings", 19


class Reader(WorkProcess):
    """Reads recordings: exports, quick looks and figures, and what is done with one that has ended. May take hours."""

    def __init__(self, nice: int = NICE) -> None:
        super().__init__(NAME, patience=None, nice=nice)


class RecordingsFolder:
    """`store`, who reads in it, and who waits for it."""

    def __init__(self, store: Store, reader: Reader) -> None:
        self.store, self._reader = store, reader
        self._turn = asyncio.Lock()
        self._lookers = ThreadPoolExecutor(LOOKERS, "recordings-folder")
        self._quick = ThreadPoolExecutor(LOOKERS, "recordings-quick")
        self._under_way: dict[tuple[object, ...], asyncio.Future[Any]] = {}

    async def look(self, work: Callable[P, T], *arguments: P.args, **named: P.kwargs) -> T:
        """`work` on the folder, in one of a few threads that only wait for it; TendrilError when it does not answer:
        a network folder that hangs must not hold up what else is done in threads, commands above all.
        """
        return await _in_time(_begun(self._lookers, partial(work, *arguments, **named)))

    async def quick(self, work: Callable[P, T], *arguments: P.args, **named: P.kwargs) -> T:
        """`work`, which takes seconds at most, by the reader; TendrilError as above. `look` does not wait behind it."""
        return await _in_time(_begun(self._quick, partial(self._reader.call, work, *arguments, **named)))

    async def quick_for_all(self, work: Callable[..., T], *arguments: Hashable) -> T:
        """The same, done once for all who ask for it while it is under way."""
        key = (work, *arguments)
        found: asyncio.Future[T] | None = self._under_way.get(key)
        if found is None:
            found = self._under_way[key] = _begun(self._quick, partial(self._reader.call, work, *arguments))
            found.add_done_callback(lambda done: self._over(key, done))
        return await _in_time(asyncio.shield(found))

    async def read(self, work: Callable[P, T], *arguments: P.args, **named: P.kwargs) -> T:
        """`work` by the reader, one after the other: each keeps a core busy. Its error, or ProcessKilled."""
        async with self._turn:
            return await self._reader.do(work, *arguments, **named)

    def close(self) -> None:
        """Wait for no one any more."""
        self._lookers.shutdown(wait=False, cancel_futures=True)
        self._quick.shutdown(wait=False, cancel_futures=True)

    def _over(self, key: tuple[object, ...], done: "asyncio.Future[Any]") -> None:
        del self._under_way[key]
        if not done.cancelled():
            done.exception()  # all who asked may have gone


def _begun(threads: ThreadPoolExecutor, work: Callable[[], T]) -> "asyncio.Future[T]":
    return asyncio.get_running_loop().run_in_executor(threads, work)


async def _in_time(found: "asyncio.Future[T]") -> T:
    try:
        return await asyncio.wait_for(found, LOOK_TIMEOUT)
    except TimeoutError:
        raise TendrilError(f"the folder of recordings does not answer within {LOOK_TIMEOUT:g} s") from None


GivenFolder = Annotated[RecordingsFolder, given(RecordingsFolder)]
GivenReader = Annotated[Reader, given(Reader)]
