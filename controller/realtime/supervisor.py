"""Keeps one rig process alive on this machine: restarts it when it dies or when its loop stands still."""

import logging
import os
import queue
import subprocess
import tempfile
import threading
import time
from pathlib import Path
from typing import IO, TYPE_CHECKING, NamedTuple

from controller.errors import RigUnreachable, StartRefused, TendrilError
from controller.realtime.settings import REFUSED, RigReady, RigSettings, failure_file, free_port
from controller.schema.parameters import RigParameters
from controller.system.child import ChildProcess, launched
from controller.system.thread import SupervisedThread

if TYPE_CHECKING:
    from controller.realtime.ring import Ring

log = logging.getLogger(__name__)

STALLED = 0.5
"""Age of the loop's heartbeat at which the process is killed [s]."""
POLL = 0.02
RETRY = 0.5
"""Wait after a look that failed [s]."""
STOP_TIMEOUT = 5.0
WATCH_MAX_S = 15.0
"""Longest time between two looks at the rig [s]: it is ended in order, for STOP_TIMEOUT at most, and killed."""
PROVEN = 200
"""Ticks after which parameters are those that a rig can run with."""
START_TIMEOUT, FIRST_TIMEOUT = 60.0, 300.0
"""Most time for a start with other parameters than those that ticked last [s]; for the first, which may compile."""


class Started(NamedTuple):
    """How a start with other parameters went."""

    parameters: RigParameters
    reason: str
    """Why it did not come to tick, "" if it did."""


class Supervisor:
    """Runs a rig as a child process, watched by a thread; the endpoint stays the same over restarts."""

    def __init__(
        self,
        settings: RigSettings,
        program: tuple[str, ...] = ("controller.realtime",),
        output: IO[bytes] | None = None,
        fallback: RigParameters | None = None,
    ) -> None:
        """`program` follows `python -m`, and the settings follow it; `output` None leaves it where ours goes.

        A rig that does not come to tick is started with the parameters that ticked last, at first with `fallback`.
        """
        self._program, self._output = program, output
        self._folder = tempfile.TemporaryDirectory(prefix="tendril-")
        self._ready_file = Path(self._folder.name, "ready.json")
        self.settings = settings.model_copy(
            update={"listen": free_port(settings.listen), "ready": self._ready_file, "parent": os.getpid()}
        )
        self.restarts = 0
        self._ticked_last, self._wanted = fallback, self.settings.parameters
        self._ticked, self._ever_ticked, self._untold = False, False, fallback is not None
        self._starts: queue.SimpleQueue[Started] = queue.SimpleQueue()
        self._child = ChildProcess(f"rig {settings.rig}", self._launch)
        self._ring: Ring | None = None
        self._late = 0.0
        self._stopping, self._replaced = threading.Event(), threading.Event()
        self._ready = threading.Event()
        self._failed_first = False
        self._first_code: int | None = None
        self.worker = SupervisedThread("rig-supervisor", self._watch, WATCH_MAX_S)

    @property
    def endpoint(self) -> str:
        """Where clients connect."""
        return self.settings.listen

    @property
    def process(self) -> int:
        """Process id of the present rig, 0 if there is none."""
        return self._child.process.pid if self._child.process else 0

    def start(self) -> None:
        """Start the rig; see `wait_ready`."""
        self.worker.start()

    def wait_ready(self) -> None:
        """Wait until the first life is ready: a cold cache compiles for a minute. Raises if it dies before."""
        if not self.is_ready(FIRST_TIMEOUT):
            raise RigUnreachable(f"rig {self.settings.rig!r} is not ready after {FIRST_TIMEOUT:.0f} s")

    def is_ready(self, timeout: float) -> bool:
        """Whether the first life is ready within `timeout` [s]; TendrilError if it died before, StartRefused if it has
        said why.
        """
        if not self._ready.wait(timeout):
            return False
        if self._failed_first:
            kind = StartRefused if self._first_code == REFUSED else TendrilError
            raise kind(f"rig {self.settings.rig!r} could not start; its own output says why")
        return True

    def replace(self, parameters: RigParameters) -> None:
        """End the rig, which vents it, and start it with other parameters; see `started`."""
        self._wanted = parameters
        self._replaced.set()

    def started(self) -> Started | None:
        """The next start with other parameters of which it is known how it went, None if there is none."""
        try:
            return self._starts.get_nowait()
        except queue.Empty:
            return None

    def stop(self) -> None:
        """End the rig with SIGTERM, after a while with SIGKILL."""
        self._stopping.set()
        self.worker.stop()
        self._child.stop(STOP_TIMEOUT)
        self._folder.cleanup()

    def _watch(self) -> None:
        """Look after look, until `stop`. What makes one of them fail is said: no one else would watch the rig."""
        over = False
        while not over and not self._stopping.wait(POLL):
            self.worker.turn()
            try:
                over = self._look()
            except Exception as error:
                log.error("%s cannot be watched: %s", self._child.name, error)
                self._stopping.wait(RETRY)

    def _look(self) -> bool:
        """One look at the rig; whether it has ended for good."""
        if self._replaced.is_set():
            self._child.stop(STOP_TIMEOUT)
            self._replaced.clear()
            self._ticked_last = self._ticked_last or self.settings.parameters  # replaced before it could be proven
            self._untold = True
            self._take(self._wanted)
        elif (code := self._child.look()) is not None:
            return self._restart(code)
        elif self._child.alive:
            self._live()
        return False

    def _launch(self) -> "subprocess.Popen[bytes]":
        self._ready_file.unlink(missing_ok=True)
        failure_file(self._ready_file).unlink(missing_ok=True)
        self._ring, self._ticked = None, False
        self._late = time.monotonic() + (START_TIMEOUT if self._ever_ticked else FIRST_TIMEOUT)
        return launched((*self._program, self.settings.model_dump_json()), self._output)

    def _live(self) -> None:
        """A look at a rig that runs: kills it when its loop stands still, or does not begin to tick."""
        if self._new and not self._ticked and time.monotonic() > self._late:
            log.error("%s: not ready in time, killed", self._child.name)
            self._child.kill()
        elif self._ring is None:
            self._ring = self._ring_when_ready()
        elif not self._ticked and self._ring.head >= PROVEN:
            self._prove()
        elif stalled(self._ring):
            log.error("%s: no tick for %.1f s, killed", self._child.name, STALLED)
            self._child.kill()

    def _restart(self, code: int) -> bool:
        """After an end that no one wanted; True when there is to be no restart."""
        if self._fall_back(code):
            return False
        if not self._ready.is_set():
            self._failed_first, self._first_code = True, code
        self._ready.set()
        if self._failed_first and self._first_code == REFUSED:
            return True  # it has said why, and would say it again; `is_ready` tells the process that started us
        fields = {"rig": self.settings.rig, "code": code}
        log.error("rig %s ended with code %s: restart", *fields.values(), extra=fields)
        self.restarts += 1
        return False

    @property
    def _new(self) -> bool:
        """There are other parameters, which ticked last, to go back to."""
        return self._ticked_last is not None and self._ticked_last != self.settings.parameters

    def _take(self, parameters: RigParameters) -> None:
        """The next life has these, and begins at once."""
        self.settings = self.settings.model_copy(update={"parameters": parameters})
        self._child.forgive()

    def _prove(self) -> None:
        """The present parameters ticked."""
        self._ticked = self._ever_ticked = True
        if self._untold:
            self._tell("")
        self._ticked_last = self.settings.parameters

    def _fall_back(self, code: int) -> bool:
        """After a start that did not come to tick, take the parameters that ticked last, and say so."""
        if self._ticked or not self._new or self._ticked_last is None:
            return False
        try:
            reason = failure_file(self._ready_file).read_text()
        except OSError:
            reason = f"it ended with code {code} before it ticked"
        back, name = self._ticked_last, self.settings.parameters.actuator.name
        fields = {"actuator": name, "reason": reason, "back": back.actuator.name}
        log.error("actuator %s did not start: %s; %s is in force again", *fields.values(), extra=fields)
        self._tell(reason)
        self._take(back)
        return True

    def _tell(self, reason: str) -> None:
        self._starts.put(Started(self.settings.parameters, reason))
        self._untold = False

    def _ring_when_ready(self) -> "Ring | None":
        from controller.realtime.ring import find_ring

        if not self._ready_file.exists():
            return None
        ready = RigReady.model_validate_json(self._ready_file.read_bytes())
        ring = find_ring(self.settings.rig, self.settings.folder)
        if ring.boot != ready.boot:
            return None
        self._ready.set()
        return ring


def stalled(ring: "Ring") -> bool:
    """The loop of this ring has not ended a tick for STALLED seconds."""
    from controller.realtime.ring import LOOP_NS

    return time.monotonic_ns() - int(ring.header[LOOP_NS]) > STALLED * 1e9
