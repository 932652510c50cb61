"""The offline observer over the decays of a file: what is asked for, checked, and what comes out."""

from dataclasses import dataclass
from pathlib import Path
from typing import TypedDict

import numpy as np

from controller.arrays import Array
from controller.errors import DataError, ParameterError
from controller.research.identification.motion.decays import Decay, long_ones, read_decays
from controller.research.identification.motion.modal import first_mode
from controller.research.identification.offline import estimate, in_plane, offline_observer
from controller.research.identification.plane import PlaneMotion, project
from controller.research.identification.score import Score, Scored, ScoringTask, score
from controller.schema.actuator import Actuator, Tracking
from controller.system.progress import ProgressCallback, no_progress


@dataclass(frozen=True)
class ObserverTask:
    """What a user asks for; bodies count from 1, as in the file's header."""

    data: Path
    actuator: Actuator
    sense: tuple[int, ...]
    score: tuple[int, ...]
    ids: str | None = None
    from_s: float = 0.3
    rods: int | None = None
    """Of the model; `table_rods` without it."""


class Scores(TypedDict):
    """Figures of one run, as JSON has them."""

    bodies: list[Score]
    samples: int
    sensed: list[int]


@dataclass(frozen=True)
class Observed:
    """Measured and estimated displacements from rest, decay by decay."""

    motions: tuple[PlaneMotion, ...]
    estimates: tuple[Array, ...]
    """(n,bodies,2) [m] each."""
    scores: Scores


def observe_decays(request: ObserverTask, told: ProgressCallback = no_progress) -> Observed:
    """Run the observer over every chosen decay of more than 150 samples, and score it.

    `told` is told the share of the decays that were observed.

    Raises DataError or ParameterError that names field, value and bound.
    """
    tracking = _tracking(request.actuator)
    offline_observer(request.actuator, sensed := _bodies("sense", request.sense, tracking), request.rods)
    scored = _bodies("score", request.score, tracking)
    if both := sorted(set(request.sense) & set(request.score)):
        raise ParameterError(f"score = {both[0]} is sensed, too: only bodies that the observer does not see are scored")
    decays = long_ones(read_decays(request.data, request.ids), "observe", request.data)
    for one in decays:
        _check(one, tracking, request.data)
    axis = np.array(tracking.axis) / np.linalg.norm(tracking.axis)
    motions, estimates, found = [project(one, axis, max(sensed)) for one in decays], [], []
    for done, motion in enumerate(motions, 1):
        estimates.append(observed_motion(request.actuator, sensed, motion, request.rods))
        found.append(to_score(request.actuator, motion, estimates[-1]))
        told(done / len(motions))
    return Observed(
        tuple(motions),
        tuple(estimates),
        Scores(
            bodies=score(found, ScoringTask(sensed, scored, starts(request.from_s))),
            samples=sum(len(one.t) for one in motions),
            sensed=[body + 1 for body in sensed],
        ),
    )


def observed_motion(actuator: Actuator, sensed: tuple[int, ...], motion: PlaneMotion, rods: int | None = None) -> Array:
    """Displacements (n,bodies,2) [m] of the model in the plane of `motion`, given its bodies `sensed` (from 0)."""
    found = estimate(offline_observer(in_plane(actuator, motion.direction), sensed, rods), motion)
    if not np.isfinite(found).all():  # a kernel cannot raise: it returns nan
        raise ParameterError(f"the observer diverged on ID {motion.id}: tracking.K_o or B_o is too large")
    return found


def to_score(actuator: Actuator, motion: PlaneMotion, found: Array) -> Scored:
    """What was found about `motion` (n,bodies,2) [m], beside the first mode of the model in its plane."""
    tracking = _tracking(actuator)
    inner = first_mode(in_plane(actuator, motion.direction), tracking.arcs)
    return Scored(motion, found[..., 1], np.append(inner, 1.0), tracking)


def _tracking(actuator: Actuator) -> Tracking:
    if actuator.tracking is None:
        raise ParameterError(f"actuator {actuator.name} has no table tracking, which says where the tracked bodies sit")
    return actuator.tracking


def _bodies(field: str, chosen: tuple[int, ...], tracking: Tracking) -> tuple[int, ...]:
    """Bodies from 0, in order."""
    bodies = len(tracking.arcs)
    if not chosen:
        raise ParameterError(f"{field} names no body: 1 to {bodies} are there")
    if wrong := [body for body in chosen if not 1 <= body <= bodies]:
        raise ParameterError(f"{field} = {wrong[0]} is outside 1 to {bodies}, the bodies of tracking.arcs")
    return tuple(sorted({body - 1 for body in chosen}))


def starts(from_s: float) -> tuple[float, ...]:
    """From when on to score: whole, and from `from_s` [s] on; ParameterError where that is no time."""
    if not 0.0 <= from_s < float("inf"):
        raise ParameterError(f"from = {from_s} s is negative or not finite")
    return (0.0, from_s) if from_s else (0.0,)


def _check(decay: Decay, tracking: Tracking, path: Path) -> None:
    _, bodies, dims = decay.points.shape
    if bodies != len(tracking.arcs):
        raise DataError(f"{path}: {bodies} bodies, tracking.arcs of the actuator has {len(tracking.arcs)}")
    if dims != len(tracking.axis):
        raise DataError(f"{path}: {dims} coordinates a body, tracking.axis of the actuator has {len(tracking.axis)}")
