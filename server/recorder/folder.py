"""The folder of recordings as routes ask it: in threads of its own, and with a bound on the wait."""

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Annotated, ParamSpec, TypeVar

from controller.errors import TendrilError
from recordings.store.store import Store
from recordings.write.writer import Recorder
from server.http.given import given

P = ParamSpec("P")
T = TypeVar("T")
LOOKERS = 4
"""Threads that may wait for the folder."""
LOOK_TIMEOUT = 30.0
"""Longest wait for an answer of it [s]: a long recording's quick look takes seconds."""


class RecordingsFolder:
    """`store` and who waits for it. `exporting`: one export at a time, as each keeps a core busy."""

    def __init__(self, store: Store) -> None:
        self.store = store
        self.exporting = asyncio.Lock()
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

    def close(self) -> None:
        """Wait for nobody any more."""
        self._lookers.shutdown(wait=False, cancel_futures=True)


GivenFolder = Annotated[RecordingsFolder, given(RecordingsFolder)]
GivenRecorder = Annotated[Recorder, given(Recorder)]
