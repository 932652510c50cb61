"""Leave-one-out: each decay is observed by the actuator that all the others identify, and then scored."""

from collections.abc import Sequence
from typing import TypedDict

import numpy as np

from controller.errors import DataError, ParameterError
from controller.research.identification.motion.decays import Decay
from controller.research.identification.motion.modal import Form
from controller.research.identification.motion.modal_fit import identified
from controller.research.identification.observe import observed_motion, to_score
from controller.research.identification.plane import project
from controller.research.identification.score import Score, Scored, ScoringTask, score
from controller.schema.actuator import Actuator
from controller.system.progress import Told, untold

FORMS = {
    "linear": Form(),
    "geometric": Form(geometric=True),
    "linear, directional": Form(directional=True),
    "geometric, directional": Form(geometric=True, directional=True),
    "as identified": None,
}
"""Stiffness profiles; the last is what `tendril identify` chooses, anew from the others for each decay left out."""


class Validated(TypedDict):
    """Scores of one form, over all left-out decays together."""

    form: str
    bodies: list[Score]


def validate(decays: Sequence[Decay], base: Actuator, task: ScoringTask, told: Told = untold) -> list[Validated]:
    """Leave-one-out scores of every form, those with directions only for decays in space.

    Raises DataError for fewer than three decays, ParameterError for bodies that are not there.
    """
    bodies, dims = decays[0].points.shape[1:]
    _refuse(decays, bodies, task)
    forms = {name: form for name, form in FORMS.items() if dims == 3 or form is None or not form.directional}
    found, steps = [], len(forms) * len(decays)
    for number, (name, form) in enumerate(forms.items()):
        scored = []
        for i in range(len(decays)):
            scored.append(_left_out(decays, i, base, form, task))
            told((number * len(decays) + i + 1) / steps)
        found.append(Validated(form=name, bodies=score(scored, task)))
    return found


def _left_out(decays: Sequence[Decay], i: int, base: Actuator, form: Form | None, task: ScoringTask) -> Scored:
    """Decay `i` as the actuator that the others identify observes it."""
    body, found, _ = identified([*decays[:i], *decays[i + 1 :]], base, form)
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
