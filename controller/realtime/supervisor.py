"""Keeps one rig process alive on this machine: restarts it when it dies or when its loop stands still."""

import logging
import os
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import IO

from controller.errors import RigUnreachable, TendrilError
from controller.parameters import RigParameters
from controller.realtime.ring import LOOP_NS, Ring, find_ring
from controller.realtime.settings import RigReady, RigSettings, free_port

log = logging.getLogger(__name__)

STALLED = 0.5
"""Age of the loop's heartbeat at which the process is killed [s]."""
POLL = 0.02
SHORT_LIFE = 5.0
"""A rig that dies younger than this a second time in a row is restarted with growing delay [s]."""
DELAY_FIRST, DELAY_MAX = 0.5, 10.0
STOP_TIMEOUT = 5.0


class Supervisor:
    """Runs a rig as a child process, watched by a thread; the endpoint stays the same over restarts."""

    def __init__(
        self,
        settings: RigSettings,
        program: tuple[str, ...] = ("controller.realtime",),
        output: IO[bytes] | None = None,
    ) -> None:
        """`program` follows `python -m`, and the settings follow it; `output` None leaves it where ours goes."""
        self._program, self._output = program, output
        self._folder = tempfile.TemporaryDirectory(prefix="tendril-")
        self._ready_file = Path(self._folder.name, "ready.json")
        self.settings = settings.model_copy(
            update={"listen": free_port(settings.listen), "ready": self._ready_file, "parent": os.getpid()}
        )
        self.restarts = 0
        self._process: subprocess.Popen[bytes] | None = None
        self._stopping, self._replaced = threading.Event(), threading.Event()
        self._ready = threading.Event()
        self._failed_first = False
        self._thread = threading.Thread(target=self._watch, name="rig-supervisor", daemon=True)

    @property
    def endpoint(self) -> str:
        """Where clients connect."""
        return self.settings.listen

    @property
    def process(self) -> int:
        """Process id of the present rig, 0 if there is none."""
        return self._process.pid if self._process else 0

    def start(self) -> None:
        """Start the rig; see `wait_ready`."""
        self._thread.start()

    def wait_ready(self, timeout: float = 300.0) -> None:
        """Wait until the first life is ready [s]: a cold cache compiles for a minute. Raises if it dies before."""
        if not self._ready.wait(timeout):
            raise RigUnreachable(f"rig {self.settings.rig!r} is not ready after {timeout:.0f} s")
        if self._failed_first:
            raise TendrilError(f"rig {self.settings.rig!r} could not start; its own output says why")

    def replace(self, parameters: RigParameters) -> None:
        """End the rig, which vents it, and start it with other parameters."""
        self.settings = self.settings.model_copy(update={"parameters": parameters})
        self._replaced.set()

    def stop(self) -> None:
        """End the rig with SIGTERM, after a while with SIGKILL."""
        self._stopping.set()
        self._thread.join()
        self._folder.cleanup()

    def _watch(self) -> None:
        quick_deaths = 0
        while not self._stopping.wait(restart_delay(quick_deaths)):
            born = time.monotonic()
            self._ready_file.unlink(missing_ok=True)
            self._process = subprocess.Popen(
                [sys.executable, "-m", *self._program, self.settings.model_dump_json()],
                stdout=self._output,
                stderr=self._output,
                start_new_session=True,  # Ctrl-C in the terminal is for us: we end the rig in order
            )
            self._live(self._process)
            if self._stopping.is_set():
                break
            self._failed_first = not self._ready.is_set()
            self._ready.set()
            if self._replaced.is_set():
                self._replaced.clear()
                quick_deaths = 0
                continue
            quick_deaths = quick_deaths + 1 if time.monotonic() - born < SHORT_LIFE else 0
            fields = {"rig": self.settings.rig, "code": self._process.poll()}
            log.error("rig %s ended with code %s: restart", *fields.values(), extra=fields)
            self.restarts += 1

    def _live(self, process: subprocess.Popen[bytes]) -> None:
        """One life of the process, until it is over; kills it when its loop stands still, ends it on `stop`."""
        ring: Ring | None = None
        while process.poll() is None:
            if self._stopping.wait(POLL) or self._replaced.is_set():
                end_process(process, STOP_TIMEOUT)
            elif ring is None:
                ring = self._ring_when_ready()
            elif stalled(ring):
                log.error("rig %s: no tick for %.1f s, killed", self.settings.rig, STALLED)
                process.kill()
                process.wait()

    def _ring_when_ready(self) -> Ring | None:
        if not self._ready_file.exists():
            return None
        ready = RigReady.model_validate_json(self._ready_file.read_bytes())
        ring = find_ring(self.settings.rig, self.settings.folder)
        if ring.boot != ready.boot:
            return None
        self._ready.set()
        return ring


def restart_delay(quick_deaths: int) -> float:
    """Wait before the next start [s] after so many short lives in a row: none after the first, then doubling."""
    return 0.0 if quick_deaths < 2 else min(DELAY_MAX, DELAY_FIRST * 2.0 ** (quick_deaths - 2))


def stalled(ring: Ring) -> bool:
    """The loop of this ring has not ended a tick for STALLED seconds."""
    return time.monotonic_ns() - int(ring.header[LOOP_NS]) > STALLED * 1e9


def end_process(process: subprocess.Popen[bytes], timeout: float) -> None:
    """End a child with SIGTERM, after `timeout` [s] with SIGKILL."""
    process.terminate()
    try:
        process.wait(timeout)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
