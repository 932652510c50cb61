"""Lines for a file that may hang: handed over without waiting, written by a thread, counted where they are left out."""

import queue
import threading
import time
from typing import Generic

from controller.system.thread import SupervisedThread
from server.log.event_file import EventFile, Line

QUEUED = 10_000
"""Lines that wait at most, some 5 MB: more than the rates let in within a minute."""
FILE_NEWS_S = 1.0
"""Between two looks for what became of the file."""
DISK_TIMEOUT_S = 10.0
"""A disk that takes none for so long is trouble [s]."""
LAST = 2.0
"""Longest wait for the last lines at the end [s]."""


class LineWriter(Generic[Line]):
    """Appends to `file`. The first OSError ends it: a full disk must not end what goes on."""

    def __init__(self, file: EventFile[Line], name: str, lost: str, queued: int = QUEUED) -> None:
        """`name` it has in the list of threads, `lost` says what it means that nothing is written."""
        self._file, self._lost, self._queued = file, lost, queued
        self._queue: queue.SimpleQueue[Line | threading.Event | None] = queue.SimpleQueue()
        self._left_out = 0
        self._problem, self._told, self._due = "", False, 0.0
        self.worker = SupervisedThread(name, self._run, DISK_TIMEOUT_S)
        self.worker.start()

    def append(self, line: Line) -> None:
        """Let it be written; left out where too many wait."""
        if self._problem:
            return
        if self._queue.qsize() >= self._queued:
            self._left_out += 1
        else:
            self._queue.put(line)

    def news(self) -> str:
        """What is to be said, once; "" where there is nothing new. To be asked now and then."""
        if self._problem and not self._told:
            self._told = True
            return f"{self._lost}: {self._problem}"
        now = time.monotonic()
        if not self._left_out or now < self._due or self._queue.qsize() >= self._queued // 2:
            return ""
        self._due, count, self._left_out = now + DISK_TIMEOUT_S, self._left_out, 0
        return f"{count} lines are missing in the {self.worker.name}: its disk was too slow"

    def flush(self, timeout: float = LAST) -> bool:
        """Wait until all that was handed over before is written; whether it is."""
        written = threading.Event()
        self._queue.put(written)
        return written.wait(timeout)

    def close(self) -> None:
        """Write what waits, as far as the disk takes it in time."""
        self._queue.put(None)
        self.worker.stop(LAST)

    def _run(self) -> None:
        while True:
            self.worker.rest()
            item = self._queue.get()
            self.worker.turn()
            if item is None:
                return
            if isinstance(item, threading.Event):
                item.set()
            elif not self._problem:
                self._write(item)

    def _write(self, line: Line) -> None:
        try:
            self._file.append(line)
        except OSError as error:
            self._problem = error.strerror or str(error)
