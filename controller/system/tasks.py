"""Tasks of the event loop: two directions of one socket, of which one ends with the other; and those nobody awaits."""

import asyncio
import logging
from collections.abc import Callable, Coroutine
from typing import Any, TypeVar

from starlette.websockets import WebSocketDisconnect
from websockets.exceptions import ConnectionClosed

log = logging.getLogger(__name__)

T = TypeVar("T")

_CLOSED = (WebSocketDisconnect, ConnectionClosed, OSError, asyncio.CancelledError)


async def until_one_ends(*directions: Coroutine[Any, Any, None]) -> None:
    """Run all, cancel the rest when the first ends; a closed socket is no error, anything else is logged."""
    tasks = [asyncio.ensure_future(direction) for direction in directions]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
        for result in await asyncio.gather(*tasks, return_exceptions=True):
            if isinstance(result, BaseException) and not isinstance(result, _CLOSED):
                log.error("socket failed", exc_info=result)


class Tasks:
    """Tasks that nobody waits for: kept until they are done, and what ends one is logged and told."""

    def __init__(self, tell: Callable[[str], None] = lambda text: None, most: int = 100) -> None:
        """At most `most` at a time: a caller that begins more without end has a mistake in it."""
        self._tell, self._most = tell, most
        self._tasks: set[asyncio.Task[Any]] = set()

    def begin(self, what: str, work: Coroutine[Any, Any, None]) -> None:
        """Do `work`, which is called `what`."""
        if len(self._tasks) >= self._most:
            work.close()
            return self._tell(f"{what} was left out: {len(self._tasks)} such tasks wait already")
        task = asyncio.create_task(work, name=what)
        self._tasks.add(task)
        task.add_done_callback(self._done)

    async def to_its_end(self, what: str, work: Coroutine[Any, Any, T]) -> T:
        """What comes of `work`, which goes on to its end though who waits for it here is cancelled."""
        task = asyncio.create_task(work, name=what)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        try:
            return await asyncio.shield(task)
        except asyncio.CancelledError:
            task.add_done_callback(self._done)  # nobody else is told what becomes of it
            raise

    def _done(self, task: "asyncio.Task[Any]") -> None:
        self._tasks.discard(task)
        if task.cancelled() or (error := task.exception()) is None:
            return
        log.error("%s failed", task.get_name(), exc_info=error)
        self._tell(f"{task.get_name()} failed: {type(error).__name__}: {error}")
