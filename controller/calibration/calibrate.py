"""The whole calibration, from the first point to the fit with its spread. What is held out is run last."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import date
from importlib.metadata import version

from controller.calibration.fit_file import Origin, Result
from controller.calibration.pool import Pool
from controller.calibration.problem import Problem
from controller.calibration.search import Effort, Report, Search, Stage
from controller.calibration.spread import held_out, near_equal, walk
from controller.errors import TendrilError

SPREAD_SHARE = 1.0 / 3.0
"""Time for the walk around the best fit, as a share of the search's budget."""


@dataclass(frozen=True)
class Task:
    """What to search, how hard, and how it is named in the file."""

    problem: Problem
    effort: Effort
    seed: int = 0
    workers: int | None = None
    command: str = "tendril calibrate"


def calibrate(task: Task, report: Report) -> Result:
    """The fit. An interrupt ends the search, not the command: the best so far is taken.

    Raises TendrilError if no point of the search kept the margins.
    """
    begin = time.monotonic()
    with Pool(task.workers) as pool:
        search = Search(task.problem, pool, task.effort, report)
        ended = search.run(task.seed)
        best = search.best()
        if best is None:
            raise TendrilError(f"{len(search.found)} points, none of which kept the margins: give more points or time")
        if ended != "interrupted":
            search.allow(SPREAD_SHARE * task.effort.minutes)
            walk(search, best, task.seed)
        fits = near_equal(search, search.best() or best)
        spread = held_out(task.problem, fits, pool, told(report, len(fits), search.best_cost))
    origin = Origin(
        date=date.today().isoformat(),
        command=task.command,
        version=version("tendril"),
        seconds=round(time.monotonic() - begin, 1),
        starts=task.effort.starts,
        evaluations=len(search.found),
        ended=ended,
    )
    return Result(task.problem, fits[0], tuple(fits), tuple(spread), origin)


def told(report: Report, fits: int, cost: float) -> Callable[[object], None]:
    """What passes the runs of the held-out rows on to `report`."""
    return lambda result: report(Stage("held-out rows", fits), cost)
