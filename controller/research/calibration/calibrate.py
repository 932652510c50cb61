"""The whole calibration, from the first point to the fit with its spread. What is held out is run last."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import date

from controller.errors import TendrilError
from controller.research.calibration.ensemble import Ensemble, walk
from controller.research.calibration.evolve import evolve
from controller.research.calibration.fit_file import FitOrigin, Result
from controller.research.calibration.problem import Evaluation, Problem
from controller.research.calibration.search import Effort, Report, Search, Stage, ending, ranked
from controller.research.calibration.spread import RowSpread, intervals, predictions
from controller.research.experiments.pool import Pool, cores
from controller.system.origin import our_version

SPREAD_SHARE = 1.0
"""Time for the walk of the near-equal fits, as a share of the search's budget."""
CUT_SHORT = ("interrupted", "a worker died")


@dataclass(frozen=True)
class CalibrationTask:
    """What to search, how hard, and how it is named in the file."""

    problem: Problem
    effort: Effort
    seed: int = 0
    workers: int | None = None
    scheduler: str | None = None
    """Address of a Dask scheduler whose workers do the work."""
    command: str = "tendril calibrate"


def calibrate(task: CalibrationTask, report: Report) -> Result:
    """The fit. An interrupt ends what is being done, not the command: what has been found is taken.

    Raises TendrilError if no point of the search kept the margins.
    """
    begin = time.monotonic()
    spread: list[RowSpread] = []
    ensemble = Ensemble()
    with Pool(task.workers or cores(), task.scheduler) as pool:
        search = Search(task.problem, pool, task.effort, report)
        ended = ending(lambda: find(search, task.seed))
        best = require_best(search, ended)
        if ended not in CUT_SHORT:
            search.allow(SPREAD_SHARE * task.effort.minutes)
            ended = worse(ended, ending(lambda: walk(search, ensemble, task.seed)))
        fits = ensemble.fits(search.best() or best)
        done = told(report, len(predictions(task.problem, fits)), search.best_cost)
        ended = worse(ended, ending(lambda: spread.extend(intervals(task.problem, fits, pool, done))))
    origin = FitOrigin(
        date=date.today().isoformat(),
        command=task.command,
        version=our_version(),
        seconds=round(time.monotonic() - begin, 1),
        starts=task.effort.starts,
        evaluations=len(search.found),
        ended=ended,
        walked=ensemble.rounds,
        accepted=ensemble.accepted / max(1, ensemble.tried),
    )
    return Result(task.problem, fits[0], tuple(fits), tuple(spread), origin)


def find(search: Search, seed: int) -> None:
    """Screen, polish, evolve, polish the best of all. Raises OutOfTime when the budget is spent."""
    search.run(seed)
    evolve(search, seed)
    search.polish(ranked(search.found)[0], "last polish")


def require_best(search: Search, ended: str) -> Evaluation:
    """The best point. Raises TendrilError if there is none, with the first point's trouble if it had any."""
    best = search.best()
    if best is None:
        reason = next((one.trouble for one in search.found if one.trouble), "give more points or time")
        raise TendrilError(f"{len(search.found)} points ({ended}), none of which kept the margins: {reason}")
    return best


def worse(ended: str, later: str) -> str:
    """How the whole ended: that its last parts ran out of time is usual, and no news."""
    return later if later in CUT_SHORT else ended


def told(report: Report, calls: int, cost: float) -> Callable[[object], None]:
    """What passes the calls of the predicted rows on to `report`."""
    return lambda result: report(Stage("predicted rows", calls), cost)
