"""The two directions of one socket, of which one ends with the other."""

import asyncio
import logging
from collections.abc import Coroutine
from typing import Any

from starlette.websockets import WebSocketDisconnect
from websockets.exceptions import ConnectionClosed

log = logging.getLogger(__name__)

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
