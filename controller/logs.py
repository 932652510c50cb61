"""Logs as one JSON object a line, for machines that read them; people read text."""

import json
import logging
import os
import sys
from datetime import UTC, datetime
from types import TracebackType
from typing import Literal

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


def logs_json() -> bool:
    """Whether `log_json` was called in this process."""
    return any(isinstance(handler.formatter, JsonLines) for handler in logging.getLogger().handlers)


def _crashed(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    log.critical("ended by %s: %s", kind.__name__, error, exc_info=(kind, error, trace))
