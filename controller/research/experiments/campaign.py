"""Runs of many cases side by side, one process a core: the same results in the same order, whatever ends first."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from controller.errors import RecordingError, TendrilError
from controller.research.experiments.catalogue import LIVE_PATH
from controller.research.experiments.pool import Pool
from controller.research.experiments.results import Failure, Finished, trace
from controller.simulation.case import Case, Outcome, Setup, run_case
from controller.simulation.live_path import run_live_case

Keep = Callable[[Outcome], None]
"""What a worker does with a whole outcome before it is thinned, such as writing a recording; it has to pickle."""
Progress = Callable[[Case], None]
"""Called in this process as soon as a case is over, in any order."""
Run = Finished | Failure


class Job(NamedTuple):
    """A case on a setup, and what is done with all of its telemetry."""

    case: Case
    setup: Setup
    keep: Keep | None = None


def campaign(jobs: Sequence[Job], workers: int, progress: Progress) -> list[Run]:
    """Every job, in the order of `jobs`; one that the rig breaks off is a Failure, and the rest go on.

    Raises ParameterError for an impossible number of workers, and TendrilError if a worker dies.
    """
    with Pool(workers) as pool:
        return pool.map(run_one, jobs, lambda run: progress(run.case))


def run_one(case: Case, setup: Setup, keep: Keep | None = None) -> Run:
    """One case from planning to its end, kept and thinned; its numbers stand even if it cannot be kept."""
    try:
        outcome = run_live_case(case, setup) if case.reference == LIVE_PATH else run_case(case, setup)
    except TendrilError as error:
        return Failure(case, str(error))
    unkept = ""
    try:
        if keep is not None:
            keep(outcome)
    except RecordingError as error:
        unkept = str(error)
    return Finished(case, outcome.reference, trace(outcome.rows, setup.controller.dt), outcome.metrics, unkept)
