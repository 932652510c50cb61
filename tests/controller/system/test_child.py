"""A child process that is kept alive, with real processes."""

import logging
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from controller.system import lifecycle as under_test
from controller.system.child import ChildProcess, restart_delay
from controller.system.lifecycle import retry_delay
from tests.controller.live_rig import wait_for

pytestmark = pytest.mark.process

Launch = Callable[[], "subprocess.Popen[bytes]"]


def python(text: str) -> "subprocess.Popen[bytes]":
    return subprocess.Popen([sys.executable, "-S", "-c", text])


@pytest.fixture
def keep() -> Iterator[Callable[[Launch], ChildProcess]]:
    kept: list[ChildProcess] = []

    def keep(launch: Launch) -> ChildProcess:
        kept.append(ChildProcess("the child", launch))
        return kept[-1]

    yield keep
    for child in kept:
        child.kill()


def codes(child: ChildProcess, count: int) -> list[int]:
    """What `look` says of the next `count` ends."""
    found: list[int] = []

    def enough() -> bool:
        if (code := child.look()) is not None:
            found.append(code)
        return len(found) == count

    wait_for(enough)
    return found


def test_every_end_is_told_once_and_followed_by_another_start(keep: Callable[[Launch], ChildProcess]) -> None:
    child = keep(lambda: python("raise SystemExit(7)"))
    assert not child.alive
    assert codes(child, 2) == [7, 7]


def test_a_child_that_lives_is_left_alone(keep: Callable[[Launch], ChildProcess]) -> None:
    child = keep(lambda: python("import time; time.sleep(60)"))
    assert child.look() is None and child.alive
    first = child.process
    assert [child.look() for _ in range(5)] == [None] * 5
    assert child.process is first


def test_what_keeps_dying_young_is_started_later_and_at_once_when_that_was_wanted(
    keep: Callable[[Launch], ChildProcess],
) -> None:
    child = keep(lambda: python(""))
    codes(child, 3)
    child.look()
    assert not child.alive, "the third young death in a row puts off the next start"
    child.forgive()
    child.look()
    assert child.process is not None and child.process.returncode is None


def test_a_start_that_the_system_refuses_is_logged_and_tried_again(
    keep: Callable[[Launch], ChildProcess], caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(under_test, "DELAY_FIRST", 0.01)
    tries: list[float] = []

    def refused_twice() -> "subprocess.Popen[bytes]":
        tries.append(time.monotonic())
        if len(tries) < 3:
            raise BlockingIOError(11, "Resource temporarily unavailable")
        return python("import time; time.sleep(60)")

    child = keep(refused_twice)
    with caplog.at_level(logging.ERROR):
        wait_for(lambda: child.look() is None and child.alive)
    assert len(tries) == 3
    assert [record.getMessage() for record in caplog.records] == [
        "the child cannot be started: [Errno 11] Resource temporarily unavailable; next try in 0.0 s"
    ] * 2
    with pytest.raises(BlockingIOError):
        tries.clear()
        keep(refused_twice).start()


def test_one_that_hears_no_sigterm_is_killed(keep: Callable[[Launch], ChildProcess], tmp_path: Path) -> None:
    deaf = (
        f"import signal, time; signal.signal(15, signal.SIG_IGN); open({str(tmp_path / 'deaf')!r}, 'w'); time.sleep(60)"
    )
    child = keep(lambda: python(deaf))
    child.start()
    wait_for((tmp_path / "deaf").exists)
    child.stop(0.1)
    assert child.process is not None and child.process.returncode == -9


def test_repeated_quick_deaths_slow_the_restarts_down() -> None:
    assert [restart_delay(deaths) for deaths in (0, 1, 2, 3, 4, 99)] == [0.0, 0.0, 0.5, 1.0, 2.0, 10.0]
    assert [retry_delay(failures) for failures in (0, 1, 2, 3, 99)] == [0.0, 0.5, 1.0, 2.0, 10.0]
