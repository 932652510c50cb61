"""A child process that is kept alive: started again when it ends, later and later while it keeps dying young."""

import logging
import os
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from typing import IO

log = logging.getLogger(__name__)

SHORT_LIFE = 5.0
"""A child that dies younger than this a second time in a row is started again with growing delay [s]."""
DELAY_FIRST, DELAY_MAX = 0.5, 10.0


class Child:
    """Acts in `look` only, so that one thread keeps it: the one that calls."""

    def __init__(self, name: str, launch: Callable[[], "subprocess.Popen[bytes]"]) -> None:
        """`launch` starts another life."""
        self.name, self._launch = name, launch
        self.process: subprocess.Popen[bytes] | None = None
        self._told = True
        self._born = self._due = 0.0
        self._deaths = self._failures = 0

    @property
    def alive(self) -> bool:
        """Whether there is a process that has not ended."""
        return self.process is not None and self.process.poll() is None

    def look(self) -> int | None:
        """Start it where that is due; the code that it ended with, once for each life.

        What the system refuses (no process, no file) is logged, and tried again: nobody else would ever start it.
        """
        if self.alive:
            return None
        if self.process is not None and not self._told:
            self._deaths = self._deaths + 1 if time.monotonic() - self._born < SHORT_LIFE else 0
            self._due, self._told = time.monotonic() + restart_delay(self._deaths), True
            return self.process.returncode
        if time.monotonic() >= self._due:
            self._try()
        return None

    def start(self) -> None:
        """Start it now; raises what the system refuses."""
        self.process = self._launch()
        self._born, self._told, self._failures = time.monotonic(), False, 0

    def forgive(self) -> None:
        """Its last end was wanted: it is not told, does not count, and the next start is due at once."""
        self._told, self._deaths, self._due = True, 0, 0.0

    def kill(self) -> None:
        """End it with SIGKILL, if it is there."""
        if self.process is not None:
            self.process.kill()
            self.process.wait()

    def end(self, timeout: float) -> None:
        """End it with SIGTERM, after `timeout` [s] with SIGKILL."""
        if self.process is None:
            return
        self.process.terminate()
        try:
            self.process.wait(timeout)
        except subprocess.TimeoutExpired:
            self.kill()

    def _try(self) -> None:
        try:
            self.start()
        except Exception as error:
            self._failures += 1
            after = retry_delay(self._failures)
            self._due = time.monotonic() + after
            log.error("%s cannot be started: %s; next try in %.1f s", self.name, error, after)


def launched(
    program: tuple[str, ...],
    output: IO[bytes] | None,
    environment: Mapping[str, str] | None = None,
    keep: tuple[int, ...] = (),
) -> "subprocess.Popen[bytes]":
    """A process that runs `python -m *program`; `output` None leaves what it prints where ours goes. It gets the
    descriptors `keep`.

    It has a session of its own: Ctrl-C in the terminal is for us, who end it in order.
    """
    return subprocess.Popen(
        [sys.executable, "-m", *program],
        env=environment if environment is None else {**os.environ, **environment},
        stdout=output,
        stderr=output,
        start_new_session=True,
        pass_fds=keep,
    )


def restart_delay(quick_deaths: int) -> float:
    """Wait before the next start [s] after this number of short lives in a row: none after the first, then doubling."""
    return 0.0 if quick_deaths < 2 else retry_delay(quick_deaths - 1)


def retry_delay(failures: int) -> float:
    """Wait after this number of failures in a row to start it [s]: 0.5 s after the first, then doubling."""
    return float(min(DELAY_MAX, DELAY_FIRST * 2.0 ** (failures - 1))) if failures else 0.0
