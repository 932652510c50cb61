"""The folder of recordings as routes ask it: in threads of its own, and with a bound on the wait.

What reads whole recordings is done by a process of its own, at low priority: the server goes on serving, and its memory
stays as it is.
"""

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Annotated, ParamSpec, TypeVar

from controller.errors import TendrilError
from controller.system.work_process import WorkProcess
from recordings.store.store import Store
from recordings.write.writer import Recorder
from server.http.given import given

P = ParamSpec("P")
T = TypeVar("T")
LOOKERS = 4
"""Threads that may wait for the folder."""
LOOK_TIMEOUT = 30.0
"""Longest wait for an answer of it [s]: a long recording's quick look takes seconds."""
NAME, NICE = "reading recordings", 19
WRITING = "writing recordings"


class Reader(WorkProcess):
    """Reads recordings: exports, quick looks and figures, and what is done with one that has ended. May take hours."""

    def __init__(self, nice: int = NICE) -> None:
        super().__init__(NAME, patience=None, nice=nice)


class Writer(WorkProcess):
    """Writes recordings, so that rerun with its libraries and threads is not in the server. May wait for a disk.

    What it has open is gone with it, so nothing is asked twice.
    """

    def __init__(self) -> None:
        super().__init__(WRITING, patience=None, tries=1)


class RecordingsFolder:
    """`store`, who reads in it, and who waits for it."""

    def __init__(self, store: Store, reader: Reader) -> None:
        self.store, self._reader = store, reader
        self._turn = asyncio.Lock()
        self._lookers = ThreadPoolExecutor(LOOKERS, "recordings-folder")

    async def look(self, work: Callable[P, T], *arguments: P.args, **named: P.kwargs) -> T:
        """`work` on the folder, in one of a few threads that only wait for it; TendrilError when it does not answer:
        a network folder that hangs must not hold up what else is done in threads, commands above all.
        """
        found = asyncio.get_running_loop().run_in_executor(self._lookers, partial(work, *arguments, **named))
        try:
            return await asyncio.wait_for(found, LOOK_TIMEOUT)
        except TimeoutError:
            raise TendrilError(f"the folder of recordings does not answer within {LOOK_TIMEOUT:g} s") from None

    async def quick(self, work: Callable[P, T], *arguments: P.args, **named: P.kwargs) -> T:
        """`work`, which takes seconds at most, by the reader; TendrilError as above."""
        return await self.look(lambda: self._reader.call(work, *arguments, **named))

    async def read(self, work: Callable[P, T], *arguments: P.args, **named: P.kwargs) -> T:
        """`work` by the reader, one after the other: each keeps a core busy. Its error, or ProcessKilled."""
        async with self._turn:
            return await self._reader.do(work, *arguments, **named)

    def close(self) -> None:
        """Wait for nobody any more."""
        self._lookers.shutdown(wait=False, cancel_futures=True)


GivenFolder = Annotated[RecordingsFolder, given(RecordingsFolder)]
GivenReader = Annotated[Reader, given(Reader)]
GivenRecorder = Annotated[Recorder, given(Recorder)]
