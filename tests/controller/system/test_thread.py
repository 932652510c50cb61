"""The life cycle of threads and children: what fails is told and begins again, and `stop` waits for the end."""

import logging
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from controller.system import lifecycle
from controller.system.child import ChildProcess
from controller.system.lifecycle import Lifecycle
from controller.system.thread import SupervisedThread, in_thread
from controller.system.work_process import WorkProcess
from tests.controller.live_rig import wait_for


def test_a_failure_is_told_and_the_thread_begins_again(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(lifecycle, "DELAY_FIRST", 0.01)
    begun: list[float] = []

    def work() -> None:
        begun.append(time.monotonic())
        if len(begun) < 3:
            raise RuntimeError(f"mistake {len(begun)}")
        thread.wait(60.0)

    thread = SupervisedThread("w", work)
    thread.start()
    wait_for(lambda: len(begun) == 3)
    assert thread.trouble == "the thread w was ended by RuntimeError: mistake 2, and began again"
    assert [record.getMessage() for record in caplog.records] == ["thread w ended, and begins again"] * 2
    assert thread.stop(60.0) and len(begun) == 3


def test_stop_waits_for_the_end_and_says_when_it_does_not_come() -> None:
    ended, may_end = threading.Event(), threading.Event()

    def work() -> None:
        assert thread.wait(60.0), "told to end long before"
        may_end.wait(60.0)
        ended.set()

    thread = SupervisedThread("w", work)
    thread.start()
    assert not thread.stop(0.05) and not ended.is_set()
    may_end.set()
    assert thread.stop(60.0) and ended.is_set() and thread.trouble == ""


def test_a_thread_that_waits_does_not_hang_and_one_that_never_began_is_stopped_at_once() -> None:
    thread = SupervisedThread("w", lambda: [thread.wait(0.2) for _ in range(2)] and None, hang_s=0.05)
    assert SupervisedThread("never", lambda: None).stop()
    thread.start()
    wait_for(lambda: not thread.alive)
    assert thread.trouble == "the thread w has ended"


def test_what_comes_of_a_thread_of_its_own_is_a_future() -> None:
    assert in_thread("w", lambda: threading.current_thread().name).result(60.0) == "w"
    with pytest.raises(ZeroDivisionError):
        in_thread("w", lambda: 1 // 0).result(60.0)


@pytest.mark.process
def test_a_killed_child_takes_with_it_what_it_runs_and_is_started_no_more_once_it_is_stopped(tmp_path: Path) -> None:
    note = tmp_path / "note"
    program = (
        "import pathlib, subprocess, sys\n"
        "run = subprocess.Popen([sys.executable, '-S', '-c', 'import time; time.sleep(600)'])\n"
        f"pathlib.Path({str(note)!r}).write_text(str(run.pid))\n"
        "run.wait()\n"
    )
    child = ChildProcess("c", lambda: subprocess.Popen([sys.executable, "-S", "-c", program], start_new_session=True))
    assert child.trouble == "c has not been started"
    child.start()
    wait_for(lambda: note.exists() and note.read_text())
    assert child.trouble == ""
    child.kill()
    stat = Path(f"/proc/{note.read_text()}/stat")
    wait_for(lambda: not stat.exists() or " Z " in stat.read_text())
    assert child.trouble == "c has ended"
    assert child.stop(1.0) and child.trouble == "" and child.look() is None and not child.alive


@pytest.mark.process
def test_threads_children_and_those_that_work_for_us_have_one_life_cycle(caplog: pytest.LogCaptureFixture) -> None:
    thread = SupervisedThread("w", lambda: thread.wait(60.0) and None)
    child = ChildProcess("c", lambda: subprocess.Popen([sys.executable, "-S", "-c", "import time; time.sleep(600)"]))
    kept: list[Lifecycle] = [thread, child, WorkProcess("p")]
    with caplog.at_level(logging.ERROR):
        for one in kept:
            one.start()
            assert one.trouble == ""
        assert all(one.stop(60.0) for one in kept)
    assert [one.trouble for one in kept] == [""] * 3 and not caplog.records
