"""The whole reproduction: every run, and what is made of them."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from controller.research.experiments.campaign import Job, Keep, Progress, Run, campaign
from controller.research.experiments.catalogue import catalogue
from controller.research.experiments.fitted_intervals import paper_fit, with_intervals
from controller.research.experiments.frequency_sweep import frequency_sweep, jobs_without_k_ff
from controller.research.experiments.letter import letter_jobs, letter_rows
from controller.research.experiments.observer_gains import observer_gains, observer_jobs
from controller.research.experiments.pressure_steps import pressure_steps
from controller.research.experiments.result_rows import result_rows
from controller.research.experiments.results import Failure, Finished, Results
from controller.research.experiments.sensing_summary import sensing_summary
from controller.simulation.case import Case, Setup, parameters_of


@dataclass(frozen=True)
class Reproduction:
    """What is to be run, on what, and how."""

    cases: tuple[Case, ...] = field(default_factory=catalogue)
    setup: Setup = field(default_factory=Setup)
    workers: int = 1
    quick: bool = False
    letter: bool = False
    """Whether the paper's equations are run to the letter beside ours."""

    @cached_property
    def observer(self) -> tuple[Job, ...]:
        """Runs with other gains of the observer."""
        return observer_jobs(self.cases, self.setup, self.quick)

    @cached_property
    def without_k_ff(self) -> tuple[Job, ...]:
        """Runs of the frequency sweep without K_FF."""
        return () if self.quick else jobs_without_k_ff(self.cases, self.setup)

    @cached_property
    def to_the_letter(self) -> tuple[Job, ...]:
        """Runs of the paper's equations to the letter."""
        return letter_jobs(self.cases, self.setup) if self.letter else ()

    @property
    def runs(self) -> int:
        """All runs that will be made."""
        return len(self.cases) + len(self.observer) + len(self.without_k_ff) + len(self.to_the_letter)


def reproduce(reproduction: Reproduction, progress: Progress, keep: Keep | None = None) -> Results:
    """Run and gather; `progress` is that of `campaign`, which says what is raised. `keep` gets the runs of `cases`."""
    begin = time.monotonic()
    jobs = [Job(case, reproduction.setup, keep) for case in reproduction.cases]
    more = (*reproduction.observer, *reproduction.without_k_ff, *reproduction.to_the_letter)
    runs = campaign([*jobs, *more], reproduction.workers, progress)
    letter = runs[len(runs) - len(reproduction.to_the_letter) :]
    own, others = runs[: len(jobs)], runs[len(jobs) : len(runs) - len(letter)]
    observed, without_k_ff = others[: len(reproduction.observer)], others[len(reproduction.observer) :]
    outcomes, failures = finished(own), failed(own)
    sweep = frequency_sweep(outcomes, failures, finished(without_k_ff))
    return Results(
        outcomes=outcomes,
        failures=(*failures, *(replace(one, sentence=f"{one.sentence} (other gains)") for one in failed(others))),
        rows=with_intervals(
            result_rows(outcomes, failures, sweep), reproduction.setup, paper_fit(reproduction.setup.twin.plant)
        ),
        sensing=sensing_summary(outcomes, failures),
        sweep=sweep,
        pressure=pressure_steps(parameters_of(Case("step"), reproduction.setup)),
        observer=observer_gains(reproduction.observer, observed, reproduction.setup, own),
        seconds=time.monotonic() - begin,
        setup=reproduction.setup,
        seeds=tuple(sorted({case.seed for case in reproduction.cases})),
        workers=reproduction.workers,
        quick=reproduction.quick,
        runs=len(runs),
        letter=letter_rows(letter, own),
    )


def finished(runs: Sequence[Run]) -> tuple[Finished, ...]:
    """Those that came to their end."""
    return tuple(run for run in runs if isinstance(run, Finished))


def failed(runs: Sequence[Run]) -> tuple[Failure, ...]:
    """Those that did not."""
    return tuple(run for run in runs if isinstance(run, Failure))
