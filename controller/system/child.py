"""A child process: started again when it ends, later and later while it keeps dying young."""

import logging
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import IO, Any

from controller.system.lifecycle import retry_delay

log = logging.getLogger(__name__)

SHORT_LIFE_S = 5.0
"""A child that dies younger than this a second time in a row is started again with growing delay."""


class ChildProcess:
    """Acts in `look` only, so that one thread keeps it: the one that calls."""

    def __init__(self, name: str, launch: Callable[[], "subprocess.Popen[bytes]"]) -> None:
        """`launch` starts another life."""
        self.name, self._launch = name, launch
        self.process: subprocess.Popen[bytes] | None = None
        self._told, self._stopped = True, False
        self._born = self._due = 0.0
        self._deaths = self._failures = 0

    @property
    def alive(self) -> bool:
        """Whether there is a process that has not ended."""
        return self.process is not None and self.process.poll() is None

    @property
    def trouble(self) -> str:
        """What is wrong with it, "" when it is well."""
        if self.alive or self._stopped:
            return ""
        return f"{self.name} has not been started" if self.process is None else f"{self.name} has ended"

    def look(self) -> int | None:
        """Start it where that is due; the code that it ended with, once for each life.

        What the system refuses (no process, no file) is logged, and tried again: no one else would ever start it.
        """
        if self.alive or self._stopped:
            return None
        if self.process is not None and not self._told:
            self._deaths = self._deaths + 1 if time.monotonic() - self._born < SHORT_LIFE_S else 0
            self._due, self._told = time.monotonic() + restart_delay(self._deaths), True
            return self.process.returncode
        if time.monotonic() >= self._due:
            self._try()
        return None

    def start(self) -> None:
        """Start it now; raises what the system refuses."""
        self.process = self._launch()
        self._born, self._told, self._failures = time.monotonic(), False, 0
        self._stopped = False

    def forgive(self) -> None:
        """Its last end was wanted: it is not told, does not count, and the next start is due at once."""
        self._told, self._deaths, self._due, self._stopped = True, 0, 0.0, False

    def kill(self) -> None:
        """End it with SIGKILL, if it is there, and what it runs."""
        if self.process is not None:
            end_now(self.process)

    def stop(self, timeout: float = 0.0) -> bool:
        """End it with SIGTERM, after `timeout` [s] with SIGKILL; it has ended then."""
        self._stopped = True
        if self.process is not None:
            self.process.terminate()
            try:
                self.process.wait(timeout)
            except subprocess.TimeoutExpired:
                self.kill()
        return True

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


def kill_session(process: "subprocess.Popen[Any]") -> None:
    """SIGKILL for `process`, and for all that it runs where it has a session of its own."""
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        process.kill()


def end_now(process: "subprocess.Popen[Any]") -> None:
    """End it at once, with what it runs, and close its pipes."""
    kill_session(process)
    process.wait()
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            with suppress(OSError):
                pipe.close()


def restart_delay(quick_deaths: int) -> float:
    """Wait before the next start [s] after this number of short lives in a row: none after the first, then doubling."""
    return 0.0 if quick_deaths < 2 else retry_delay(quick_deaths - 1)
