"""The whole reproduction: every run, and what is made of them."""

import time
from dataclasses import dataclass, field

from controller.experiments.campaign import Keep, Progress, campaign
from controller.experiments.case import Case, Setup, parameters_of
from controller.experiments.catalogue import catalogue
from controller.experiments.frequency_sweep import frequency_sweep
from controller.experiments.observer_gains import observer_gains
from controller.experiments.pressure_steps import pressure_steps
from controller.experiments.result_rows import result_rows
from controller.experiments.results import Failure, Finished, Results
from controller.experiments.sensing_summary import sensing_summary


@dataclass(frozen=True)
class Order:
    """What is to be run, on what, and how."""

    cases: tuple[Case, ...] = field(default_factory=catalogue)
    setup: Setup = field(default_factory=Setup)
    workers: int = 1
    quick: bool = False


def reproduce(order: Order, progress: Progress, keep: Keep | None = None) -> Results:
    """Run and gather; `progress` and `keep` are those of `campaign`, which says what is raised."""
    begin = time.monotonic()
    runs = campaign(order.cases, order.setup, order.workers, progress, keep)
    outcomes = tuple(run for run in runs if isinstance(run, Finished))
    failures = tuple(run for run in runs if isinstance(run, Failure))
    sweep = frequency_sweep(outcomes, failures)
    seeds = tuple(sorted({case.seed for case in order.cases}))
    return Results(
        outcomes=outcomes,
        failures=failures,
        rows=result_rows(outcomes, failures, sweep),
        sensing=sensing_summary(outcomes),
        sweep=sweep,
        pressure=pressure_steps(parameters_of(Case("step"), order.setup)),
        observer=observer_gains(order.setup, min(seeds)),
        seconds=time.monotonic() - begin,
        setup=order.setup,
        seeds=seeds,
        workers=order.workers,
        quick=order.quick,
    )
