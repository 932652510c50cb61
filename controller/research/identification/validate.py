"""Leave-one-out: each decay is observed by the actuator that all the others identify, and then scored."""

from collections.abc import Sequence
from typing import NamedTuple, TypedDict

import numpy as np

from controller.errors import DataError, ParameterError
from controller.research.identification.motion.decays import Decay
from controller.research.identification.motion.modal import TRACKING_RATE, Form
from controller.research.identification.motion.modal_fit import identified
from controller.research.identification.observe import observed_motion, to_score
from controller.research.identification.plane import project
from controller.research.identification.score import Score, Scored, ScoringTask, score
from controller.schema.actuator import Actuator
from controller.system.progress import ProgressCallback, no_progress

RATES = 1.0, 2000.0
"""Bounds of the observer's rate [rad/s]."""

FORMS = {
    "linear": Form(),
    "geometric": Form(geometric=True),
    "linear, directional": Form(directional=True),
    "geometric, directional": Form(geometric=True, directional=True),
}
CHOSEN = "as identified"
"""What `tendril identify` chooses, again from the others for each decay left out."""


class Trial(NamedTuple):
    """One way to identify, under its name."""

    name: str
    form: Form | None = None
    """Without one, what the decays bear."""
    rate: float = TRACKING_RATE


def trials(rate: float | None, *, every: bool) -> list[Trial]:
    """What is identified, and `every` form, with the observer's springs at `rate` [rad/s] or as fast as usual.

    Raises ParameterError for a rate outside RATES.
    """
    rate = TRACKING_RATE if rate is None else rate
    if not RATES[0] <= rate <= RATES[1]:
        raise ParameterError(f"rate = {rate} rad/s is outside [{RATES[0]:g}, {RATES[1]:g}]")
    forms = [Trial(name, form, rate) for name, form in FORMS.items()] if every else []
    return [*forms, Trial(CHOSEN, None, rate)]


class Validated(TypedDict):
    """Scores of one form, over all left-out decays together."""

    form: str
    rate: float
    bodies: list[Score]


def validate(
    decays: Sequence[Decay],
    base: Actuator,
    task: ScoringTask,
    tried: Sequence[Trial],
    told: ProgressCallback = no_progress,
) -> list[Validated]:
    """Leave-one-out scores of every trial, those with directions only for decays in space.

    Raises DataError for fewer than three decays, ParameterError for bodies that are not there.
    """
    bodies, dims = decays[0].points.shape[1:]
    _refuse(decays, bodies, task)
    tried = [one for one in tried if dims == 3 or one.form is None or not one.form.directional]
    found = []
    for number, trial in enumerate(tried):
        scored = []
        for i in range(len(decays)):
            scored.append(_left_out(decays, i, base, trial, task))
            told((number + (i + 1) / len(decays)) / len(tried))
        found.append(Validated(form=trial.name, rate=trial.rate, bodies=score(scored, task)))
    return found


def _left_out(decays: Sequence[Decay], i: int, base: Actuator, trial: Trial, task: ScoringTask) -> Scored:
    """Decay `i` as the actuator that the others identify observes it."""
    body, found, _ = identified([*decays[:i], *decays[i + 1 :]], base, trial.form, trial.rate)
    actuator = body.shaped(found.shape)
    assert actuator.tracking is not None
    motion = project(decays[i], np.array(actuator.tracking.axis), max(task.sensed))
    return to_score(actuator, motion, observed_motion(actuator, task.sensed, motion))


def _refuse(decays: Sequence[Decay], bodies: int, task: ScoringTask) -> None:
    if len(decays) < 3:
        raise DataError(f"{len(decays)} decays: leaving one out needs at least 3")
    if wrong := [body + 1 for body in (*task.sensed, *task.scored) if not 0 <= body < bodies]:
        raise ParameterError(f"body {wrong[0]} is outside 1 to {bodies}")
    if both := set(task.sensed) & set(task.scored):
        raise ParameterError(
            f"score = {min(both) + 1} is sensed, too: only bodies that the observer does not see count"
        )
