"""The pool on a Dask cluster: the same results as on this machine's processes, whatever becomes of a worker."""

import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from controller.errors import ParameterError, TendrilError
from controller.research.experiments.cluster import require_same
from controller.research.experiments.pool import OutOfTime, Pool
from controller.system.origin import our_version

pytestmark = pytest.mark.keyed()

NOT_THERE = "dask.distributed is not installed: pip install 'tendril-softrobotics[cluster]'"


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    """A scheduler on this machine with two workers of one thread, each with a process that starts it again."""
    distributed = pytest.importorskip("distributed", reason=NOT_THERE)
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None, silence_logs=50
    ) as found:
        yield found


def square(number: int) -> int:
    return number * number


def fragile(number: int, mark: Path) -> int:
    """Kill the worker that comes here first: with all that it was given, and the results that lie on it."""
    time.sleep(0.05)
    if number == 5 and not mark.exists():
        mark.touch()
        os._exit(1)
    return number * number


def refuses(number: int) -> int:
    raise ParameterError(f"number = {number} is odd")


def test_a_cluster_gives_the_same_results_in_the_same_order(cluster: Any) -> None:
    seen: list[int] = []
    with Pool(1, cluster.scheduler_address) as pool:
        assert pool.map(square, [(n,) for n in range(20)], seen.append) == [n * n for n in range(20)]
        assert pool.map(square, [(2,), (2,)]) == [4, 4]
    assert sorted(seen) == [n * n for n in range(20)]


def test_a_lost_worker_loses_nothing(cluster: Any, tmp_path: Path) -> None:
    with Pool(1, cluster.scheduler_address) as pool:
        calls = [(n, tmp_path / "killed") for n in range(12)]
        assert pool.map(fragile, calls) == [n * n for n in range(12)]
    assert (tmp_path / "killed").exists()


def test_an_error_of_the_work_and_the_end_of_the_time_come_through(cluster: Any) -> None:
    with Pool(1, cluster.scheduler_address) as pool:
        with pytest.raises(ParameterError, match="number = 1 is odd"):
            pool.map(refuses, [(1,)])
        with pytest.raises(OutOfTime):
            pool.map(time.sleep, [(0.2,)] * 8, over=lambda: True)
        assert pool.map(square, [(3,)]) == [9]


def test_an_address_where_nobody_answers_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed", reason=NOT_THERE)
    monkeypatch.setattr("controller.research.experiments.cluster.CONNECT_SECONDS", 0.5)
    with (
        Pool(1, "tcp://127.0.0.1:9") as pool,
        pytest.raises(ParameterError, match=r"scheduler = 'tcp://127.0.0.1:9' does not answer"),
    ):
        pool.map(square, [(1,)])


def test_without_dask_the_command_that_installs_it_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with (
        Pool(1, "tcp://127.0.0.1:9") as pool,
        pytest.raises(ParameterError, match=r"needs dask\.distributed: .*install"),
    ):
        pool.map(square, [(1,)])


def test_workers_of_another_version_are_refused() -> None:
    require_same({"tcp://a:1": our_version()})
    with pytest.raises(TendrilError, match=r"worker tcp://b:2 has Tendril 0\.0\.9"):
        require_same({"tcp://a:1": our_version(), "tcp://b:2": "0.0.9"})
