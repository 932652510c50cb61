"""Start and end in order: who asks for the end once the start was said is obeyed as at any other time.

While operators still hear and the recording still runs, the rig is brought to rest and vents.
"""

import asyncio
import logging
import signal
import socket
import threading
import time
from collections.abc import Callable, Coroutine
from typing import Any

import uvicorn

from controller.errors import TendrilError
from controller.schema.modes import Mode, Request
from controller.system.loop_watchdog import LoopWatchdog
from server.access.permit import own
from server.app.application_loop import ApplicationLoop
from server.app.services import Services

log = logging.getLogger(__name__)

VENT_MAX_S = 8.0
"""Longest wait until the rig is vented [s]; it goes on to rest without this server too."""
POLL = 0.02
LAST_LOOK = 0.2
"""So that pages and recording have the last rows, too [s]."""
_DEPRESSURED = (Mode.VENTED, Mode.FAULT, Mode.E_STOP)
"""Vented, or on the way there whatever is asked."""


class Server(uvicorn.Server):
    """uvicorn that says `ready` when it is, first lets `before_end` run, every socket still open, and ends with 0."""

    def __init__(
        self,
        config: uvicorn.Config,
        application: ApplicationLoop,
        before_end: Callable[[], Coroutine[Any, Any, None]],
        ready: Callable[[], None],
        deadly: Callable[[], None] | None = None,
    ) -> None:
        """`before_end` is done in the loop of the `application`; `deadly` as in `LoopWatchdog`, of the network's."""
        super().__init__(config)
        self._application, self._before_end, self._ready = application, before_end, ready
        self._watchdog = LoopWatchdog(deadly, "network loop")

    def run(self, sockets: list[socket.socket] | None = None) -> None:
        """Serve until stopped: the application in this thread, the network beside it. SIGTERM and SIGINT ask for the
        end; uvicorn would raise them again after it, and end with code -15.
        """
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGTERM, signal.SIGINT):
                signal.signal(number, self.handle_exit)
        self._application.run(lambda: super(Server, self).run(sockets))

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Connections are accepted, and a signal ends in order, when `ready` is said."""
        self._watchdog.start()
        await super().startup(sockets)
        self._ready()

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """End in order."""
        await self._application.do(self._before_end())
        await super().shutdown(sockets)
        if not self.force_exit:
            await self._application.ended.wait()
        self._watchdog.stop()
        await self._hang_up()

    async def _hang_up(self) -> None:
        """Wait for nobody: under TLS a page that does not say goodbye would keep uvloop, and this process, for ever."""
        for connection in list(self.server_state.connections):
            connection.transport.abort()
        await asyncio.sleep(0)


async def come_to_rest(services: Services) -> None:
    """Tell operators, take no more motion, and let the rig rest; done when it is vented, or after `VENT_MAX_S`."""
    operator, rig = services.operator, services.rig
    if rig.boot() is None or rig.trouble or (mode := _mode(services)) in _DEPRESSURED:
        return services.events.add("the server shuts down", "warning")
    services.events.add("the server shuts down: the rig comes to rest", "warning")
    operator.leave()
    try:
        reply = await asyncio.wrap_future(operator.request(Request.REST, own()))
    except TendrilError as error:
        return log.warning("the rig was not asked to rest: %s", error)
    if not reply.accepted:
        return log.warning("the rig does not rest from %s: %s", mode.name, reply.detail)
    end = time.monotonic() + VENT_MAX_S
    while _mode(services) not in _DEPRESSURED and rig.boot() is not None and time.monotonic() < end:
        await asyncio.sleep(POLL)
    await asyncio.sleep(LAST_LOOK)
    log.info("the rig is %s", _mode(services).name)


def _mode(services: Services) -> Mode:
    newest = services.history.newest
    return Mode.VENTED if newest is None else Mode(int(newest[0]["mode"]))
