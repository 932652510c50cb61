"""What fails, ends or hangs inside the server: it is said, everything else goes on, and an E-STOP passes."""

import asyncio
import logging
import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from controller.errors import RecordingError
from controller.schema.messages import RigInfo
from controller.schema.parameters import RigParameters, Settings
from controller.system import lifecycle
from controller.system.logs import Background
from controller.system.loop_watchdog import LoopWatchdog
from controller.system.scheduler import FAILURE_FORGOTTEN_S, ErrorGuard, Scheduler
from controller.system.thread import SupervisedThread
from recordings.format.annotations import LogLine
from recordings.write.queue import NoAnswer, RecorderQueue
from recordings.write.session import Session
from recordings.write.writer import Recorder
from server.health.monitor import HealthMonitor
from server.live.hub import Viewer
from server.log.event_file import EventFile
from server.log.events import EventLog, LogEntry
from server.log.line_writer import LineWriter
from tests.server.live_server import ROW, TestServer, wait_for

INFO = RigInfo(
    rig="r", boot=1, version="", layout="", wall_offset_ns=0, policy="", twin=True, parameters=RigParameters()
)


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def test_a_call_that_fails_is_logged_once_with_its_count_and_the_others_go_on(caplog: pytest.LogCaptureFixture) -> None:
    guard, seen, clock = ErrorGuard(clock := Clock()), [], clock

    def fail() -> None:
        raise RecordingError("there is no recording 'x'")

    for _ in range(3600):
        guard.do("the recording of a killed server", fail)
        guard.do("the alarms", lambda: seen.append(1))
    assert len(seen) == 3600 and len(caplog.records) == 1
    [trouble] = guard.troubles
    assert trouble.endswith("fails: RecordingError: there is no recording 'x', 3600 times")
    clock.now = FAILURE_FORGOTTEN_S + 1.0
    assert guard.troubles == []


def joined(server: TestServer) -> Viewer:
    """The only page, once what is said from now on reaches it."""
    viewer: Viewer
    [viewer] = wait_for(lambda: [*server.services.pages.open], "the page")
    return viewer


def test_a_server_one_of_whose_jobs_fails_serves_frames_status_and_e_stop(server: TestServer) -> None:
    page = server.operator()

    def fail() -> None:
        raise RuntimeError("the look is broken")

    with page.live() as live:
        joined(server)
        server.services.scheduler.jobs["the procedure under way"].call = fail
        wait_for(lambda: "the look is broken" in page.get("/api/health").json()["server"], "the trouble")
        frames, statuses = len(live.frames), len([text for text in live.texts if text["type"] == "status"])
        wait_for(lambda: len(live.frames) > frames + 60, "frames")
        wait_for(lambda: len([text for text in live.texts if text["type"] == "status"]) > statuses + 1, "a status")
        assert (
            live.wait("event", lambda line: "the procedure under way fails: RuntimeError" in line["text"])["level"]
            == "error"
        )
        health = page.get("/healthz")
        assert health.status_code == 503 and not health.json()["server"]["ok"]
        assert page.command("e_stop").status_code == 200


def test_a_thread_that_ends_is_said_and_begins_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lifecycle, "DELAY_FIRST", 0.01)
    ends, over = [SystemExit(3), RuntimeError("by a mistake")], threading.Event()

    def work() -> None:
        if ends:
            raise ends.pop(0)
        over.wait()

    worker = SupervisedThread("w", work)
    worker.start()
    wait_for(lambda: not ends and worker.alive and "by a mistake" in worker.trouble, "another start of it")
    events = EventLog()
    monitor = HealthMonitor([worker], Scheduler(), events)
    monitor.check()
    monitor.check()
    assert [event.text for event in events.recent] == [
        "the thread w was ended by RuntimeError: by a mistake, and began again"
    ]
    over.set()
    assert worker.stop(60.0)


def test_a_thread_that_hangs_is_seen() -> None:
    go_on = threading.Event()
    worker = SupervisedThread("w", go_on.wait, hang_s=0.05)
    worker.start()
    wait_for(lambda: worker.trouble == "the thread w hangs", "the trouble")
    go_on.set()
    assert worker.stop(60.0) and worker.trouble == ""


async def test_a_task_that_is_not_awaited_does_not_fail_in_silence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("controller.system.scheduler.TASKS_MAX", 1)
    told, scheduler = list[str](), Scheduler()
    scheduler.tell = told.append

    async def fail() -> None:
        raise RuntimeError("no")

    scheduler.begin("the end of a recording", fail())
    scheduler.begin("the end of a recording", fail())
    scheduler.begin("another", asyncio.sleep(0.0))
    await asyncio.sleep(0.05)
    assert told == [
        "the end of a recording was left out: 1 such tasks wait already",
        "the end of a recording failed: RuntimeError: no",
    ]


async def test_a_loop_that_stands_still_is_said_with_the_place_and_ended_if_it_stays(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("controller.system.loop_watchdog.SLOW_S", 0.2)
    monkeypatch.setattr("controller.system.loop_watchdog.DEADLY_S", 0.6)
    ended = threading.Event()
    watchdog = LoopWatchdog(ended.set)
    watchdog.start()
    await asyncio.sleep(0.1)
    end = time.monotonic() + 60.0
    while not ended.is_set() and time.monotonic() < end:
        time.sleep(0.01)  # the loop hangs here
    assert ended.is_set()
    await asyncio.sleep(0.5)
    watchdog.stop()
    assert "time.sleep(0.01)  # the loop hangs here" in caplog.text
    assert watchdog.trouble.startswith("the event loop stood still for")


async def test_time_in_which_the_loop_stands_still_is_no_time_in_which_it_listened() -> None:
    watchdog = LoopWatchdog()
    watchdog.start()
    await asyncio.sleep(0.5)
    before = watchdog.listened()
    time.sleep(3.0)
    await asyncio.sleep(0.5)
    watchdog.stop()
    assert 0.0 < before and before < watchdog.listened() < before + 2.0


def test_an_operator_who_is_there_still_operates_after_the_loop_has_stood_still(
    server: TestServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = server.page().sign_in().operate()
    with page.live() as live:
        live.operate()
        live.wait("hello")
        monkeypatch.setattr(server.services.lease, "_lapse", 2.0)
        viewer = joined(server)
        term = server.services.lease.term
        viewer.wake._loop.call_soon_threadsafe(time.sleep, 4.0)  # type: ignore[attr-defined]
        live.wait("event", lambda line: "the event loop stood still" in line["text"])
        assert server.services.lease.holder is not None and server.services.lease.term == term
        assert not [said for said in live.texts if "no longer operates" in said.get("text", "")]


@pytest.fixture
def hung() -> Iterator[threading.Event]:
    """Set by a test when its disk is to answer again."""
    answers = threading.Event()
    yield answers
    answers.set()


def rows(first: int, count: int = 10) -> Any:
    import numpy as np

    found = np.zeros(count, ROW)
    found["tick"] = first + np.arange(count)
    found["t_ns"] = 1_000_000 * found["tick"]
    return found


def test_a_disk_that_hangs_ends_the_recording_and_holds_up_nobody(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, hung: threading.Event
) -> None:
    recorder = Recorder(tmp_path, patience=0.3)
    recorder.start("hung", INFO, Settings())
    write = Session.write

    def hang(session: Session, batch: Any) -> None:
        hung.wait()
        write(session, batch)

    monkeypatch.setattr(Session, "write", hang)
    for batch in range(100_000):
        recorder.rows(rows(10 * batch))
        recorder.annotate(LogLine("a line of the log"))
        recorder.look()
        if batch > 2000 and not recorder.state().recording:
            break
        time.sleep(1e-4)
    state = recorder.state()
    assert (state.recording, "the disk has taken nothing for 0.3 s" in state.problem) == (False, True)
    assert recorder._queue._queue.qsize() <= 6500
    with pytest.raises(RecordingError, match="the disk does not answer"):
        recorder.start("another", INFO, Settings())
    with pytest.raises(RecordingError, match="the disk does not answer"):
        recorder.stop()
    hung.set()
    wait_for(lambda: not recorder._given_up and recorder._session is None, "the disk's return")
    monkeypatch.undo()
    assert recorder.start("after", INFO, Settings()).recording
    recorder.stop()
    recorder.close()


def test_rerun_s_slow_first_call_is_not_taken_for_a_disk_that_hangs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("recordings.write.rrd.warm_up", lambda: time.sleep(1.0))
    recorder = Recorder(tmp_path, patience=0.2)
    time.sleep(0.5)
    assert recorder.worker.trouble == ""
    assert recorder.start("early", INFO, Settings()).recording
    recorder.close()


def test_a_server_that_stood_still_does_not_take_that_for_a_disk_that_hangs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, hung: threading.Event
) -> None:
    recorder = Recorder(tmp_path, patience=0.3)
    recorder.start("stopped", INFO, Settings())
    monkeypatch.setattr(Session, "write", lambda session, batch: hung.wait())
    recorder.rows(rows(0))
    recorder.look()
    time.sleep(1.5)  # as when the process is stopped: no one looks
    recorder.look()
    assert recorder.state().recording
    for _ in range(50):
        time.sleep(0.02)
        recorder.look()
    assert "the disk has taken nothing for 0.3 s" in recorder.state().problem
    hung.set()
    recorder.close()


def test_nothing_that_is_handed_to_the_recorder_waits() -> None:
    waiting = RecorderQueue(batches=3, jobs=2)
    waiting.open(-1)
    for tick in range(10):
        waiting.rows(rows(10 * tick))
    assert (waiting.full, waiting.is_open) == (True, False)
    assert [waiting.later(lambda: None) for _ in range(3)] == [True, True, False]
    assert waiting.left_out == 1
    with pytest.raises(NoAnswer, match=r"nothing came of it within 0.05 s"):
        waiting.ask(lambda: None, 0.05)


def test_a_log_file_that_hangs_holds_up_no_line_and_says_what_is_missing(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")  # to open it for writing waits for a reader

    class Pipe(EventFile[LogEntry]):
        def append(self, event: LogEntry) -> None:
            with (tmp_path / "pipe").open("a") as file:
                file.write(event.text)

    log = EventLog(Pipe(tmp_path / "events.jsonl", LogEntry))
    log.writer = LineWriter(Pipe(tmp_path / "events.jsonl", LogEntry), "event log", "lost", queued=10)
    for number in range(100):
        log.add(f"line {number}")
    assert len(log.recent) == 100
    descriptor = os.open(tmp_path / "pipe", os.O_RDWR)
    wait_for(lambda: (log.look(), "lines are missing in the event log" in log.recent[-1].text)[1], "the count")
    os.close(descriptor)


@pytest.mark.process
def test_a_standard_error_that_nobody_reads_holds_up_nobody() -> None:
    """A process whose log goes into a pipe that is full."""
    script = (
        "import logging, sys, time\n"
        "from controller.system.logs import log_in_background\n"
        "logging.basicConfig(level=logging.INFO)\n"
        "log_in_background()\n"
        "for _ in range(20_000): logging.info('x' * 200)\n"
        "print('done', flush=True)\n"
    )
    process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout is not None
    assert process.stdout.readline() == b"done\n"
    process.kill()
    process.communicate()


def test_lines_in_the_background_keep_their_order_and_their_fields() -> None:
    seen: list[str] = []

    class Keep(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            seen.append(record.getMessage())

    background = Background([Keep()])
    for number in range(100):
        background.handle(logging.makeLogRecord({"msg": "line %d", "args": (number,)}))
    background.flush()
    assert seen == [f"line {number}" for number in range(100)]
