"""A log record as one line of JSON."""

import json
import logging
from datetime import datetime

from controller.system.logs import JsonLines


def line(record: logging.LogRecord) -> dict[str, object]:
    text = JsonLines("rig").format(record)
    assert len(text.splitlines()) == 1
    found: dict[str, object] = json.loads(text)
    return found


def record(message: str, *values: object, extra: dict[str, object] | None = None) -> logging.LogRecord:
    return logging.getLogger("a.b").makeRecord("a.b", logging.WARNING, "x.py", 1, message, values, None, extra=extra)


def test_a_record_has_its_time_level_and_fields_by_name() -> None:
    found = line(record("%d of %s", 3, "four", extra={"rig": "twin", "count": 3}))
    assert (found["message"], found["level"], found["process"], found["logger"]) == (
        "3 of four",
        "warning",
        "rig",
        "a.b",
    )
    assert (found["rig"], found["count"]) == ("twin", 3)
    assert datetime.fromisoformat(str(found["time"])).tzinfo is not None


def test_no_message_can_begin_a_line_of_its_own() -> None:
    assert line(record('x\n{"level": "forged"}\r\u2028'))["level"] == "warning"


def test_what_json_does_not_know_is_text_and_a_traceback_is_a_field() -> None:
    try:
        raise ValueError("deep inside")
    except ValueError as error:
        found = record("failed", extra={"where": object})
        found.exc_info = (type(error), error, error.__traceback__)
    assert "deep inside" in str(line(found)["exception"])
    assert line(found)["where"] == str(object)
