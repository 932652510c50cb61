"""The log outlives the server that wrote it."""

import stat
from datetime import timedelta
from pathlib import Path

from server.log.event_file import EventFile
from server.log.events import REPEATED, EventLog, LogEntry
from tests.server.live_server import RigProcess, TestServer, free_environment


def texts(log: EventLog) -> list[str]:
    return [event.text for event in log.recent]


def written(log: EventLog) -> None:
    assert log.writer is not None and log.writer.flush(60.0)


def test_a_restarted_server_tells_what_was_refused_before(shared_rig: RigProcess, tmp_path: Path) -> None:
    free_environment()
    first = TestServer(tmp_path, shared_rig.endpoint)
    viewer = first.page().sign_in()
    assert viewer.command("arm").status_code == 403
    first.close()
    second = TestServer(tmp_path, shared_rig.endpoint)
    with second.page().sign_in().live() as live:
        log = live.wait("hello")["log"]
    second.close()
    refusals = [line for line in log if "arm refused" in line["text"]]
    assert len(refusals) == 1
    assert refusals[0]["level"] == "warning"
    assert [line["time"] for line in log] == sorted(line["time"] for line in log)


def test_a_torn_last_line_is_left_out_and_spoils_no_later_one(tmp_path: Path) -> None:
    path = tmp_path / "events.jsonl"
    log = EventLog(EventFile(path, LogEntry))
    log.add("before")
    written(log)
    with path.open("ab") as file:
        file.write(b'{"type":"event","time":"2026-01-01T00:0')
    log = EventLog(EventFile(path, LogEntry))
    assert texts(log) == ["before"]
    log.add("after")
    written(log)
    assert texts(EventLog(EventFile(path, LogEntry))) == ["before", "after"]
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_the_files_stay_small_and_the_last_200_lines_are_read_back(tmp_path: Path) -> None:
    path = tmp_path / "events.jsonl"
    log = EventLog(EventFile(path, LogEntry, largest=20_000))
    for number in range(1000):
        log.add(f"line {number}")
    written(log)
    assert sum(file.stat().st_size for file in tmp_path.iterdir()) < 2 * 20_200
    assert texts(EventLog(EventFile(path, LogEntry))) == [f"line {number}" for number in range(800, 1000)]


def test_what_is_said_again_counts_up_in_one_line_and_buries_nothing(tmp_path: Path) -> None:
    path = tmp_path / "events.jsonl"
    log = EventLog(EventFile(path, LogEntry), kept=3)
    log.add("ann: arm")
    for number in range(50):
        log.add(f"late by {number}", "warning", "alarm late")
        log.add(f"lost {number}", "warning", "alarm lost")
    written(log)
    lines = [("ann: arm", 1), ("late by 49", 50), ("lost 49", 50)]
    assert [(event.text, event.count) for event in log.recent] == lines
    assert [(event.text, event.count) for event in EventLog(EventFile(path, LogEntry)).recent] == lines
    assert len(path.read_text().splitlines()) == 101, "the file has every line"


def test_what_was_said_long_ago_is_said_again() -> None:
    log = EventLog()
    log.add("late", "warning", "alarm late")
    log.recent[0] = log.recent[0].model_copy(update={"time": log.recent[0].time - REPEATED - timedelta(seconds=1)})
    log.add("late", "warning", "alarm late")
    log.add("late", "warning", "alarm late")
    assert [event.count for event in log.recent] == [1, 2]


def test_a_log_that_cannot_be_kept_says_so_once_and_goes_on(tmp_path: Path) -> None:
    log = EventLog(EventFile(tmp_path / "nowhere" / "events.jsonl", LogEntry))
    log.add("one")
    written(log)
    for _ in range(3):
        log.look()
    log.add("two")
    assert len(texts(log)) == 3
    assert "will not outlive" in texts(log)[1]
