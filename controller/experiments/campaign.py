"""Runs of many cases side by side, one process a core: the same results in the same order, whatever ends first."""

from collections.abc import Callable, Sequence
from functools import partial

from controller.errors import TendrilError
from controller.experiments.case import Case, Outcome, Setup, run_case
from controller.experiments.catalogue import LIVE_PATH
from controller.experiments.live_path import run_live_case
from controller.experiments.pool import Pool
from controller.experiments.results import Failure, Finished, trace

Keep = Callable[[Outcome], None]
"""What a worker does with a whole outcome before it is thinned, such as writing a recording; it has to pickle."""
Progress = Callable[[Case], None]
"""Called in this process as soon as a case is over, in any order."""
Run = Finished | Failure


def campaign(
    cases: Sequence[Case], setup: Setup, workers: int, progress: Progress, keep: Keep | None = None
) -> list[Run]:
    """Every case on `setup`, in the order of `cases`; a case that the rig breaks off is a Failure, and the rest go on.

    Raises ParameterError for an impossible number of workers, and TendrilError if a worker dies.
    """
    work = partial(run_one, setup=setup, keep=keep)
    with Pool(workers) as pool:
        return pool.map(work, [(case,) for case in cases], lambda run: progress(run.case))


def run_one(case: Case, setup: Setup, keep: Keep | None) -> Run:
    """One case from planning to its end, kept and thinned."""
    try:
        outcome = run_live_case(case, setup) if case.reference == LIVE_PATH else run_case(case, setup)
    except TendrilError as error:
        return Failure(case, str(error))
    if keep is not None:
        keep(outcome)
    return Finished(case, outcome.reference, trace(outcome.rows, setup.controller.dt), outcome.metrics)
