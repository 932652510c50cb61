"""The event loop under a watchdog: a thread that notes when the loop does not turn, says where it hangs, and ends it.

While the loop hangs no one is heard: no E-STOP passes through this server. Presence stops with it, so the rig holds
after 0.5 s. But the operator's thread goes on repeating the last command, so the rig would stay in HOLD under pressure
for ever. So a loop that stands still for DEADLY_S ends the process: `tendril up` or systemd starts another one,
which takes about as long again, and the rig, hearing no one, rests after 30 s if that fails.

What a person did not say while no one listened is no silence of theirs, so there is a clock of the time in which the
loop turned: `listened`.
"""

import asyncio
import faulthandler
import logging
import os
import sys
import threading
import time
import traceback
from collections.abc import Callable

from controller.system.logs import flush_log
from controller.system.thread import SupervisedThread

log = logging.getLogger(__name__)

TURN_NOTED_S = 0.1
"""Between two turns of the loop that are noted, and between two looks of the watchdog [s]."""
SLOW_S = 1.0
"""A loop that stands still for so long is said, with where it hangs [s]: 60 of its beats are missing then."""
DEADLY_S = 10.0
"""After so long the process is ended [s]: well below the 30 s after which operators could rely on the rig's own rest if
this server were silent."""
TROUBLE_S = 60.0
"""For which a loop that stood still is trouble [s]."""


def end_process() -> None:
    """End this process at once, as a kill would: nothing can be done in order, the loop would have to do it."""
    flush_log()
    faulthandler.dump_traceback(all_threads=True)
    os._exit(os.EX_SOFTWARE)


class LoopWatchdog:
    """`start` it in the loop. Time in which this process itself was stopped does not count, as its thread was too."""

    def __init__(self, deadly: Callable[[], None] | None = None, name: str = "event loop") -> None:
        """`deadly` is called, from the watchdog's thread, when the loop has not turned for DEADLY_S, if given; `name`
        is what the log calls the loop.
        """
        self._deadly, self._name = deadly, name
        self._turns = 0
        self._turned = self._listened = 0.0
        self._stood, self._longest, self._last, self._count = 0.0, 0.0, -TROUBLE_S, 0
        self._main = threading.get_ident()
        self._thread = SupervisedThread(f"{name} watchdog", self._run)
        self._timer: asyncio.TimerHandle | None = None

    def start(self) -> None:
        """Watch the running loop."""
        self._main = threading.get_ident()
        self._turned = time.monotonic()
        self._turn(asyncio.get_running_loop())
        self._thread.start()

    def stop(self) -> None:
        """Watch no more."""
        self._thread.stop(0.0)
        if self._timer is not None:
            self._timer.cancel()

    @property
    def alive(self) -> bool:
        """Whether anybody watches."""
        return self._thread.alive or self._thread.stopping or not self._thread.started

    @property
    def standing(self) -> float:
        """For how long the loop has not turned [s]."""
        return self._stood

    def listened(self) -> float:
        """For how long the loop has turned since the start [s], to TURN_NOTED_S: what stood still is left out."""
        return self._listened

    @property
    def trouble(self) -> str:
        """What was wrong with the loop within the last minute, "" if nothing was."""
        if not self.alive:
            return f"no one watches the {self._name}"
        if self._stood < SLOW_S and time.monotonic() - self._last > TROUBLE_S:
            return ""
        return f"the {self._name} stood still for {max(self._longest, self._stood):.1f} s"

    def _turn(self, loop: asyncio.AbstractEventLoop) -> None:
        self._turns += 1
        before, self._turned = self._turned, time.monotonic()
        self._listened += min(self._turned - before, 2 * TURN_NOTED_S)
        if not self._thread.stopping:
            self._timer = loop.call_later(TURN_NOTED_S, self._turn, loop)

    def _run(self) -> None:
        seen, woken = self._turns, time.monotonic()
        while not self._thread.wait(TURN_NOTED_S):
            now = time.monotonic()
            passed, woken = min(now - woken, 2 * TURN_NOTED_S), now
            if self._turns != seen:
                seen = self._turns
                self._went_on(now)
                continue
            before, self._stood = self._stood, self._stood + passed
            if before < SLOW_S <= self._stood:
                self._say()
            if self._stood >= DEADLY_S and self._deadly is not None:
                log.critical("the %s has not turned for %.0f s: this process ends", self._name, self._stood)
                self._deadly()

    def _went_on(self, now: float) -> None:
        if self._stood >= SLOW_S:
            if now - self._last > TROUBLE_S:
                self._longest = 0.0
            self._longest, self._last = max(self._longest, self._stood), now
            self._count += 1
            log.error("the %s goes on after %.1f s", self._name, self._stood)
        self._stood = 0.0

    def _say(self) -> None:
        frame = sys._current_frames().get(self._main)
        where = "".join(traceback.format_stack(frame)) if frame else "(its thread is gone)\n"
        log.error("the %s has not turned for %.1f s; it is in\n%s", self._name, self._stood, where)
