"""Calls made side by side, one process a core or on a cluster: the same results in order, whatever ends first."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import forkserver
from multiprocessing.context import BaseContext
from multiprocessing.process import BaseProcess
from types import TracebackType
from typing import Any, Self, TypeVar

from controller.errors import ParameterError, TendrilError
from controller.research.experiments import cluster
from controller.system.thread import in_thread

T = TypeVar("T")
WORKERS_MAX = 256
POLL = 0.5
"""How often a wait looks whether it is over [s]."""


class OutOfTime(Exception):
    """The budget is spent. Not an error: what has been found stands."""


class WorkerDied(TendrilError):
    """A process of a pool was killed from outside."""


def cores() -> int:
    """Cores that this process may use."""
    return min(len(os.sched_getaffinity(0)), WORKERS_MAX)


class Pool:
    """Processes that start with the work and stay until the pool is closed; one alone is this process itself.

    With the address of a Dask scheduler its workers do the work instead: what a lost one had is done by another.
    An interrupt is for this process: `map` raises it, the others finish what they have begun, and the pool works on.
    A pool that is left with an error ends its processes at once.
    """

    def __init__(self, workers: int, scheduler: str | None = None) -> None:
        if not 1 <= workers <= WORKERS_MAX:
            raise ParameterError(f"workers = {workers} is outside [1, {WORKERS_MAX}]")
        self.workers = workers
        self.scheduler = scheduler
        self._executor: Executor | None = None
        self._strangers: set[BaseProcess] = set()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._close(at_once=kind is not None)

    def map(
        self,
        work: Callable[..., T],
        calls: Iterable[tuple[Any, ...]],
        done: Callable[[T], None] = lambda result: None,
        over: Callable[[], bool] = lambda: False,
    ) -> list[T]:
        """Results of `work(*call)` in the order of the calls; `done` sees each as it comes.

        Raises OutOfTime once `over` says so, WorkerDied, and what `work` raises; either way nothing more is begun.
        """
        if self.workers == 1 and self.scheduler is None:
            return list(_one_by_one(work, list(calls), done, over))
        futures: list[Future[T]] = []
        try:
            for call in calls:
                futures.append(self._running().submit(work, *call))
            _collect(set(futures), done, over)
            return [future.result() for future in futures]
        except BrokenProcessPool as error:
            self._close(at_once=True)
            raise WorkerDied("a worker process died (out of memory?): try again with --workers 1") from error
        except cluster.lost() as error:
            self._close(at_once=True)
            raise WorkerDied(f"the cluster at {self.scheduler} gave up: {error}") from error
        except BaseException:
            for future in futures:
                future.cancel()
            raise

    def _running(self) -> Executor:
        """The processes, or the way to the cluster; new ones where there are none, or none any more."""
        if self._executor is None and self.scheduler is not None:
            self._executor = cluster.connected(self.scheduler)
        if self._executor is None:
            self._strangers = set(multiprocessing.active_children())
            self._executor = ProcessPoolExecutor(self.workers, _context(), initializer=_begin)
        return self._executor

    def _close(self, at_once: bool) -> None:
        executor, self._executor = self._executor, None
        if executor is None:
            return
        if at_once and self.scheduler is None:
            for worker in set(multiprocessing.active_children()) - self._strangers:
                worker.terminate()  # no one waits for what has begun
        executor.shutdown(wait=True, cancel_futures=True)


def _one_by_one(
    work: Callable[..., T], calls: list[tuple[Any, ...]], done: Callable[[T], None], over: Callable[[], bool]
) -> Iterable[T]:
    for number, call in enumerate(calls, 1):
        result = work(*call)
        done(result)
        yield result
        if number < len(calls) and over():
            raise OutOfTime


def _collect(waiting: set[Future[T]], done: Callable[[T], None], over: Callable[[], bool]) -> None:
    while waiting:
        finished, waiting = wait(waiting, POLL, FIRST_COMPLETED)
        for future in finished:
            done(future.result())
        if waiting and over():
            raise OutOfTime


def _context() -> BaseContext:
    """Where workers come from: a server that ignores ctrl-C, and so do they from their first import on.

    Only the main thread may set that; elsewhere an interrupt does not arrive anyway.
    """
    if threading.current_thread() is threading.main_thread():
        before = signal.signal(signal.SIGINT, signal.SIG_IGN)
        try:
            forkserver.ensure_running()
        finally:
            signal.signal(signal.SIGINT, before)
    return multiprocessing.get_context("forkserver")


def _begin() -> None:
    """In a worker: leave ctrl-C to the parent, and end with it, however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()

    def follow() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    in_thread("parent", follow)
