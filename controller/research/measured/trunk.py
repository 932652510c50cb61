"""Free decays of a soft trunk: bodies that are not seen, by the observer, identified on other decays."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from controller.research.identification.motion.decays import long_ones, read_decays
from controller.research.identification.motion.modal_fit import identified
from controller.research.identification.observe import observed_motion, to_score
from controller.research.identification.plane import project
from controller.research.identification.score import Score, ScoringTask, score
from controller.research.measured.sets import Answer, MeasuredSet, Question
from controller.schema.actuator import PRESETS

FILE = "trunk-stack/decay_200g_even_ids.csv"
IDENTIFIED, UNSEEN = "0-16", "18-34"
TASK = ScoringTask(sensed=(2,), scored=(1, 0), starts=(0.3,))


def answers(paths: Mapping[str, Path]) -> list[Answer]:
    """Lateral error of bodies 2 and 1 from 0.3 s on, in percent of their motion."""
    body, found, _ = identified(read_decays(paths[FILE], IDENTIFIED), PRESETS["P1"])
    actuator = body.shaped(found.shape)
    assert actuator.tracking is not None
    axis, scored = np.array(actuator.tracking.axis), []
    for decay in long_ones(read_decays(paths[FILE], UNSEEN), "observe", paths[FILE]):
        motion = project(decay, axis, max(TASK.sensed))
        scored.append(to_score(actuator, motion, observed_motion(actuator, TASK.sensed, motion)))
    return [Answer(one["percent_of_motion"], baselines(one)) for one in score(scored, TASK)]


def baselines(one: Score) -> dict[str, float]:
    """What needs no model, and the model without its dynamics."""
    found = {
        "constant curvature": one["constant_curvature_percent"],
        "fixed ratio": one["fixed_ratio_percent"],
        "first mode's shape": one["mode_shape_percent"],
    }
    return {name: share for name, share in found.items() if share is not None}


TRUNK = MeasuredSet(
    name="trunk decays",
    source="tests/data of this repository, from github.com/StanfordASL/trunk-stack",
    licence="MIT",
    files=(FILE,),
    questions=tuple(
        Question(f"body {n} from body 3, from 0.3 s after the release", "rms error", "% of motion") for n in (2, 1)
    ),
    answers=answers,
)
