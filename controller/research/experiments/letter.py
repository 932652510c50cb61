"""The paper's equations to the letter beside ours, wherever both are FF+PI: where the letter fails, it shows."""

from collections.abc import Sequence
from dataclasses import replace

from controller.research.experiments.campaign import Job, Run
from controller.research.experiments.catalogue import LIVE_PATH
from controller.research.experiments.paper_rows import paper_row, window_of
from controller.research.experiments.results import Failure, Finished, LetterRow
from controller.simulation.case import LETTER, Case, Setup

OURS = "ff+pi"


def letter_jobs(cases: Sequence[Case], setup: Setup) -> tuple[Job, ...]:
    """The first seed of every case under FF+PI again, to the letter; a live path is no run of the paper's."""
    first = min(case.seed for case in cases)
    return tuple(
        Job(Case(case.reference, case.actuator, LETTER, case.seed), setup)
        for case in cases
        if case.law == OURS and case.seed == first and case.reference != LIVE_PATH
    )


def letter_rows(runs: Sequence[Run], own: Sequence[Run]) -> tuple[LetterRow, ...]:
    """`runs` are those of `letter_jobs`, `own` among others ours of the same cases."""
    ours = {run.case: run for run in own}
    return tuple(letter_row(run, ours[replace(run.case, law=OURS)]) for run in runs)


def letter_row(letter: Run, ours: Run) -> LetterRow:
    """One run under both."""
    case = letter.case
    name = "frequency_sweep" if case.reference.startswith("frequency_sweep") else case.reference
    return LetterRow(
        case.reference,
        case.actuator,
        paper_row(name, case.actuator, OURS, "rmse").paper,
        rmse_of(ours, name),
        rmse_of(letter, name),
        letter.sentence if isinstance(letter, Failure) else "",
    )


def rmse_of(run: Run, experiment: str) -> float | None:
    """RMSE [mm] in the paper's window; None for a run that the rig broke off."""
    return run.metrics[window_of(experiment)]["rmse"] if isinstance(run, Finished) else None
