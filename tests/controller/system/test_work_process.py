"""A process that works for another: answers, errors, and what becomes of those who wait when it is killed."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from controller.errors import ParameterError, ProcessKilled, TendrilError
from controller.system.work_process import NICE, WorkProcess
from tests.controller.live_rig import wait_for

pytestmark = [pytest.mark.process, pytest.mark.keyed()]

PROGRAM = """
import os, pathlib, sys, time
note = pathlib.Path(sys.argv[1])
note.with_suffix(".part").write_text(str(os.getpid()))
note.with_suffix(".part").replace(note)
time.sleep(600)
"""


@pytest.fixture
def process() -> Iterator[WorkProcess]:
    found = WorkProcess("planning")
    yield found
    found.stop()


def double(rows: np.ndarray) -> np.ndarray:
    return 2.0 * rows


def refuse(text: str) -> None:
    raise ParameterError(text)


def stumble() -> None:
    _ = 1 / 0


def unsendable() -> Any:
    return threading.Lock()


def unfit() -> Any:
    return Unfit()


class Unfit:
    """Comes, but cannot be read where it arrives."""

    def __reduce__(self) -> Any:
        return int, ("not a number",)


def wait_until_there(path: Path) -> int:
    while not path.exists():
        time.sleep(0.01)
    return os.getpid()


def run_program(note: Path) -> None:
    """Runs a program that never ends; its process id stands in `note` once it runs."""
    subprocess.run([sys.executable, "-c", PROGRAM, str(note)], check=False)


def die(notes: Path, times: int) -> str:
    """Kill the process that works, for the first `times`."""
    lives = len(list(notes.iterdir()))
    if lives < times:
        (notes / str(lives)).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return f"life {lives}"


def test_it_works_in_another_process_which_is_kept(process: WorkProcess) -> None:
    assert process.pid is None
    first = process.call(os.getpid)
    assert first == process.pid != os.getpid()
    assert process.call(os.getpid) == first


def test_arrays_go_there_and_back(process: WorkProcess) -> None:
    rows = np.arange(1_000_000.0).reshape(-1, 2)
    assert (process.call(double, rows) == 2.0 * rows).all()


def test_our_own_error_comes_as_it_is(process: WorkProcess) -> None:
    with pytest.raises(ParameterError, match=r"^speed = 3 m/s$") as found:
        process.call(refuse, "speed = 3 m/s")
    assert not hasattr(found.value, "__notes__")


def test_any_other_error_says_where_it_was(process: WorkProcess) -> None:
    with pytest.raises(ZeroDivisionError) as found:
        process.call(stumble)
    assert "in stumble" in found.value.__notes__[0]


@pytest.mark.parametrize(("work", "error"), [(unsendable, RuntimeError), (unfit, ValueError)])
def test_an_answer_that_cannot_come_is_an_error(process: WorkProcess, work: Any, error: type[Exception]) -> None:
    with pytest.raises(error):
        process.call(work)
    assert process.call(os.getpid) == process.pid


async def test_long_work_does_not_keep_the_short(process: WorkProcess, tmp_path: Path) -> None:
    long = threading.Thread(target=process.call, args=(wait_until_there, tmp_path / "go"))
    long.start()
    assert await process.do(os.getpid) == process.pid
    (tmp_path / "go").touch()
    long.join()


def test_one_that_is_killed_is_started_again_and_asked_once_more(process: WorkProcess, tmp_path: Path) -> None:
    assert process.call(die, tmp_path, 1) == "life 1"


def test_one_that_is_killed_twice_is_an_error_for_the_user(process: WorkProcess, tmp_path: Path) -> None:
    with pytest.raises(ProcessKilled, match="planning: its process was killed twice, perhaps for want of memory"):
        process.call(die, tmp_path, 2)
    assert process.call(die, tmp_path, 2) == "life 2"


def test_one_that_hangs_is_ended(tmp_path: Path) -> None:
    process = WorkProcess("planning", patience=0.5)
    try:
        with pytest.raises(ProcessKilled, match=r"planning took more than 0.5 s; it was ended"):
            process.call(wait_until_there, tmp_path / "never")
        wait_for(lambda: process.pid is None)
    finally:
        process.stop()


def test_closing_tells_who_waits(process: WorkProcess, tmp_path: Path) -> None:
    caught: list[TendrilError] = []

    def ask() -> None:
        try:
            process.call(wait_until_there, tmp_path / "never")
        except TendrilError as error:
            caught.append(error)

    waiting = threading.Thread(target=ask)
    waiting.start()
    wait_for(lambda: process.pid)
    process.stop()
    waiting.join()
    assert isinstance(caught[0], ProcessKilled)


def test_it_ends_with_the_one_that_it_works_for() -> None:
    program = (
        "import os, signal\n"
        "from controller.system.work_process import WorkProcess\n"
        "print(WorkProcess('planning').call(os.getpid), flush=True)\n"
        "os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    wait_until_gone(int(done.stdout))


def test_a_program_that_it_runs_ends_with_the_one_that_it_works_for(tmp_path: Path) -> None:
    program = (
        "import sys\n"
        "from pathlib import Path\n"
        "from controller.system.work_process import WorkProcess\n"
        "from tests.controller.system.test_work_process import run_program\n"
        "WorkProcess('reading').call(run_program, Path(sys.argv[1]))\n"
    )
    note = tmp_path / "note"
    asker = subprocess.Popen([sys.executable, "-c", program, str(note)], cwd=Path(__file__).parents[3])
    wait_for(note.exists)
    asker.kill()
    asker.wait()
    wait_until_gone(int(note.read_text()))


@pytest.mark.parametrize("how", ["killed", "closed"])
def test_a_program_that_it_runs_ends_with_it(process: WorkProcess, tmp_path: Path, how: str) -> None:
    note = tmp_path / "note"

    def ask() -> None:
        with suppress(ProcessKilled):
            process.call(run_program, note)

    waiting = threading.Thread(target=ask)
    waiting.start()
    wait_for(note.exists)
    program = int(note.read_text())
    if how == "killed":
        os.kill(cast(int, process.pid), signal.SIGKILL)
    else:
        process.stop()
    wait_until_gone(program)
    process.stop()
    waiting.join()


def test_it_gives_way_to_the_process_that_asks(process: WorkProcess) -> None:
    assert process.call(os.nice, 0) == max(os.nice(0), NICE)
    nice = WorkProcess("reading", nice=19)
    assert nice.call(os.nice, 0) == 19
    nice.stop()


def wait_until_gone(pid: int) -> None:
    """Until no such process runs; one that has ended and that no one has asked after may be left."""
    wait_for(lambda: not Path(f"/proc/{pid}").exists() or " Z " in Path(f"/proc/{pid}/stat").read_text())
