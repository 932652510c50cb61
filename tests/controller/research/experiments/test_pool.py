"""Processes that work side by side: order, budget, interrupts and deaths."""

import os
import signal
import time
from pathlib import Path

import pytest

from controller.research.experiments.pool import OutOfTime, Pool, WorkerDied, cores

pytestmark = pytest.mark.alone


def delayed(number: int, seconds: float) -> int:
    time.sleep(seconds)
    return number


def touched(file: Path, seconds: float) -> None:
    time.sleep(seconds)
    file.touch()


def interrupt(result: object) -> None:
    raise KeyboardInterrupt


def hears_interrupts() -> bool:
    return signal.getsignal(signal.SIGINT) is not signal.SIG_IGN


@pytest.mark.parametrize("workers", [1, 2])
def test_results_keep_their_order_whatever_ends_first_and_each_is_told_once(workers: int) -> None:
    told: list[int] = []
    with Pool(workers) as pool:
        assert pool.map(delayed, [(0, 0.5), (1, 0.0), (2, 0.0)], told.append) == [0, 1, 2]
    assert sorted(told) == [0, 1, 2]


@pytest.mark.parametrize("workers", [1, 2])
def test_a_spent_budget_ends_the_work_but_not_the_pool(workers: int) -> None:
    told: list[int] = []
    with Pool(workers) as pool:
        with pytest.raises(OutOfTime):
            pool.map(delayed, [(number, 0.0) for number in range(300)], told.append, lambda: bool(told))
        assert 0 < len(told) < 300
        assert pool.map(delayed, [(7, 0.0)], over=lambda: True) == [7]


def test_an_interrupt_reaches_the_caller_and_not_the_workers_and_the_pool_works_on() -> None:
    with Pool(2) as pool:
        assert pool.map(hears_interrupts, [()]) == [False]
        with pytest.raises(KeyboardInterrupt):
            pool.map(delayed, [(0, 0.0), (1, 0.0)], interrupt)
        assert pool.map(delayed, [(2, 0.0)]) == [2]


def test_a_pool_that_is_left_with_an_error_waits_for_nobody(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt), Pool(2) as pool:
        pool.map(touched, [(tmp_path / "first", 0.0), (tmp_path / "second", 120.0)], interrupt)
    assert [file.name for file in tmp_path.iterdir()] == ["first"]


def test_a_worker_that_dies_is_said_so_and_another_takes_its_place() -> None:
    with Pool(2) as pool:
        with pytest.raises(WorkerDied, match="a worker process died"):
            pool.map(os._exit, [(1,)])
        assert pool.map(delayed, [(3, 0.0)]) == [3]


def test_only_cores_that_the_process_may_use_are_counted() -> None:
    allowed = os.sched_getaffinity(0)
    try:
        os.sched_setaffinity(0, {min(allowed)})
        assert cores() == 1
    finally:
        os.sched_setaffinity(0, allowed)
