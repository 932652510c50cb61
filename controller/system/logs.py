"""Logs as one JSON object a line, for machines that read them; people read text."""

import atexit
import json
import logging
import os
import queue
import sys
import threading
from datetime import UTC, datetime
from types import TracebackType
from typing import Literal

from controller.system.thread import SupervisedThread

LogFormat = Literal["text", "json"]

_OWN = frozenset(logging.makeLogRecord({}).__dict__) | {"message", "asctime", "color_message"}
"""What every record has; anything else was given as `extra`, and becomes a field."""

log = logging.getLogger(__name__)


class JsonLines(logging.Formatter):
    """{"time", "level", "process", "pid", "logger", "message", ...}: fields of `extra` by their names, a traceback as
    `exception`. A line break in a message is escaped, so a line is always a whole object.
    """

    def __init__(self, process: str) -> None:
        super().__init__()
        self._process = process

    def format(self, record: logging.LogRecord) -> str:
        """The record as JSON; what JSON does not know is written as text."""
        line = {
            "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "process": self._process,
            "pid": os.getpid(),
            "logger": record.name,
            "message": record.getMessage(),
        }
        line |= {name: value for name, value in record.__dict__.items() if name not in _OWN}
        if record.exc_info:
            line["exception"] = self.formatException(record.exc_info)
        return json.dumps(line, default=str)


def log_json(process: str) -> None:
    """From now on this process, called "rig", "server" or "up", logs JSON to its standard error, crashes included."""
    handler = logging.StreamHandler()
    handler.setFormatter(JsonLines(process))
    logging.basicConfig(level=logging.INFO, handlers=[handler], force=True)
    logging.captureWarnings(True)
    sys.excepthook = _crashed


QUEUED = 10_000
"""Lines that wait for a standard error that takes none; what comes beyond them is left out, and counted."""
LAST = 1.0
"""Longest wait for the last lines at the end [s]."""


class Background(logging.Handler):
    """Passes records on to `handlers` from a thread: a pipe that no one reads holds up nothing but the log itself."""

    def __init__(self, handlers: list[logging.Handler]) -> None:
        super().__init__()
        self._handlers = handlers
        self._queue: queue.SimpleQueue[logging.LogRecord | threading.Event] = queue.SimpleQueue()
        self._left_out = 0
        self.setFormatter(handlers[0].formatter if handlers else None)
        SupervisedThread("log", self._run).start()

    def emit(self, record: logging.LogRecord) -> None:
        """Hand the record over, with its text as it is now."""
        if self._queue.qsize() >= QUEUED:
            self._left_out += 1
            return
        count, self._left_out = self._left_out, 0
        text = record.getMessage()
        record.msg, record.args = f"{text} ({count} lines before it were left out)" if count else text, None
        self._queue.put(record)

    def flush(self) -> None:
        """Wait until all of it is written, but not for long."""
        written = threading.Event()
        self._queue.put(written)
        written.wait(LAST)

    def _run(self) -> None:
        while True:
            item = self._queue.get()
            if isinstance(item, threading.Event):
                item.set()
                continue
            for handler in self._handlers:
                try:
                    handler.handle(item)
                except Exception:  # a log that cannot be written must not end the log
                    handler.handleError(item)


def log_in_background() -> None:
    """From now on no thread of this process waits for the reader of its log."""
    root = logging.getLogger()
    if root.handlers and not any(isinstance(handler, Background) for handler in root.handlers):
        root.handlers[:] = [background := Background(root.handlers[:])]
        atexit.register(background.flush)


def flush_log() -> None:
    """Let what was logged be written, before this process ends without an orderly end."""
    for handler in logging.getLogger().handlers:
        handler.flush()


def logs_json() -> bool:
    """Whether `log_json` was called in this process."""
    return any(isinstance(handler.formatter, JsonLines) for handler in logging.getLogger().handlers)


def _crashed(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    log.critical("ended by %s: %s", kind.__name__, error, exc_info=(kind, error, trace))
