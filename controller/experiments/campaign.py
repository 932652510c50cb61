"""Runs of many cases side by side, one process a core: the same results in the same order, whatever ends first."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from multiprocessing import forkserver
from multiprocessing.context import BaseContext

from controller.errors import ParameterError, TendrilError
from controller.experiments.case import Case, Outcome, Setup, run_case
from controller.experiments.catalogue import LIVE_PATH
from controller.experiments.live_path import run_live_case
from controller.experiments.results import Failure, Finished, trace

Keep = Callable[[Outcome], None]
"""What a worker does with a whole outcome before it is thinned, such as writing a recording; it has to pickle."""
Progress = Callable[[Case], None]
"""Called in this process as soon as a case is over, in any order."""
Run = Finished | Failure
WORKERS_MAX = 256


def campaign(
    cases: Sequence[Case], setup: Setup, workers: int, progress: Progress, keep: Keep | None = None
) -> list[Run]:
    """Every case on `setup`, in the order of `cases`; a case that the rig breaks off is a Failure, and the rest go on.

    Raises ParameterError for an impossible number of workers, and TendrilError if a worker dies.
    """
    if not 1 <= workers <= WORKERS_MAX:
        raise ParameterError(f"workers = {workers} is outside [1, {WORKERS_MAX}]")
    work = partial(run_one, setup=setup, keep=keep)
    if workers == 1:
        return [_told(work(case), progress) for case in cases]
    strangers = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(min(workers, len(cases)), context())
    try:
        futures = [pool.submit(work, case) for case in cases]
        for future in as_completed(futures):
            _told(_result(future), progress)
        return [future.result() for future in futures]
    except BaseException:
        for worker in set(multiprocessing.active_children()) - strangers:
            worker.terminate()  # nobody waits for the runs that have begun
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def context() -> BaseContext:
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


def cores() -> int:
    """Cores that this process may use."""
    return min(len(os.sched_getaffinity(0)), WORKERS_MAX)


def run_one(case: Case, setup: Setup, keep: Keep | None) -> Run:
    """One case from planning to its end, kept and thinned."""
    try:
        outcome = run_live_case(case, setup) if case.reference == LIVE_PATH else run_case(case, setup)
    except TendrilError as error:
        return Failure(case, str(error))
    if keep is not None:
        keep(outcome)
    return Finished(case, outcome.reference, trace(outcome.rows, setup.controller.dt), outcome.metrics)


def _told(run: Run, progress: Progress) -> Run:
    progress(run.case)
    return run


def _result(future: Future[Run]) -> Run:
    try:
        return future.result()
    except BrokenProcessPool as error:
        raise TendrilError("a worker process died (out of memory?): try again with --workers 1") from error
