"""Points evaluated side by side, over processes: the same points give the same numbers whatever their number."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from types import TracebackType
from typing import Any, Self, TypeVar

from controller.errors import TendrilError

T = TypeVar("T")
POLL = 0.5
"""How often a wait looks whether it is over [s]."""


class OutOfTime(Exception):
    """The budget of a search is spent. Not an error: what has been found stands."""


class Pool:
    """Processes that work until they are closed. An interrupt is for the parent alone."""

    def __init__(self, workers: int | None = None) -> None:
        self.workers = workers or os.cpu_count() or 1
        if self.workers < 1:
            raise TendrilError(f"workers = {workers} is below 1")
        context = multiprocessing.get_context("spawn")
        self._executor = ProcessPoolExecutor(self.workers, context, initializer=_begin)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._executor.shutdown(wait=True, cancel_futures=True)

    def map(
        self,
        work: Callable[..., T],
        calls: Iterable[tuple[Any, ...]],
        done: Callable[[T], None] = lambda result: None,
        over: Callable[[], bool] = lambda: False,
    ) -> list[T]:
        """Results of `work(*call)` in the order of the calls; `done` sees each as it comes.

        Raises OutOfTime once `over` says so, and what `work` raises; either way nothing more is begun.
        """
        futures = [self._executor.submit(work, *call) for call in calls]
        try:
            _collect(set(futures), done, over)
        except BaseException:
            for future in futures:
                future.cancel()
            raise
        return [future.result() for future in futures]


def _collect(waiting: set[Future[T]], done: Callable[[T], None], over: Callable[[], bool]) -> None:
    while waiting:
        finished, waiting = wait(waiting, POLL, FIRST_COMPLETED)
        for future in finished:
            done(future.result())
        if waiting and over():
            raise OutOfTime


def _begin() -> None:
    """Leave ctrl-C to the parent, and end with it, however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()

    def follow() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=follow, daemon=True).start()
