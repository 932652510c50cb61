"""How well an estimate of unsensed bodies is, beside what needs no model (docs/identification.md)."""

from collections.abc import Sequence
from typing import NamedTuple, TypedDict

import numpy as np

from controller.arrays import Array
from controller.errors import ParameterError
from controller.research.identification.plane import PlaneMotion
from controller.schema.actuator import Tracking

STARTS = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.75, 1.0, 1.5)
"""Times after release from which motions are summed up, for the fixed ratios [s]."""

STILL = 1e-9
"""A body that moves less than this does not move [m]."""

SAME = 1e-6
"""Times nearer than this are the same [s]."""


class ScoringTask(NamedTuple):
    """Which bodies (from 0) are sensed, which are scored, and from when."""

    sensed: tuple[int, ...]
    scored: tuple[int, ...]
    starts: tuple[float, ...]
    """[s] after the first sample."""


class Score(TypedDict):
    """One scored body in one window."""

    body: int
    from_s: float
    rms_error_mm: float
    rms_motion_mm: float
    percent_of_motion: float
    constant_curvature_percent: float
    fixed_ratio_percent: float


def products(motions: Sequence[PlaneMotion]) -> tuple[tuple[float, ...], ...]:
    """For each of STARTS the mean products of the lateral motions (bodies x bodies, row by row) [m^2]."""
    pooled = [np.concatenate([_late(one, one.lateral, start) for one in motions]) for start in STARTS]
    kept = [y for y in pooled if len(y)]
    return tuple(tuple((y.T @ y / len(y)).ravel().tolist()) for y in kept)


def fixed_ratios(tracking: Tracking, sensed: Sequence[int], body: int, from_s: float) -> Array:
    """Factors (s,) of the sensed lateral motions whose sum is nearest to the body's in the identified decays."""
    known = [i for i, start in enumerate(tracking.starts) if start <= from_s + SAME]
    if not known:
        raise ParameterError(
            f"tracking.starts = {tracking.starts} s of the actuator file has nothing from {from_s} s on"
        )
    bodies = len(tracking.arcs)
    gram = np.array(tracking.products[known[-1]]).reshape(bodies, bodies)
    ratios, *_ = np.linalg.lstsq(gram[np.ix_(sensed, sensed)], gram[list(sensed), body], rcond=None)
    return np.asarray(ratios)


def constant_curvature(sensed: int, body: int) -> float:
    """Ratio of lateral motions of two bodies (from 0) on a circular arc that leaves the clamp along x.

    y = kappa s^2 / 2, with the bodies taken as evenly spaced: measured arc lengths are already part of a model.
    """
    return ((body + 1) / (sensed + 1)) ** 2


def score(
    motions: Sequence[PlaneMotion], estimates: Sequence[Array], tracking: Tracking, task: ScoringTask
) -> list[Score]:
    """Each scored body from each start; `estimates` are the lateral motions (n,bodies) [m] that the model gives.

    Errors and motions of all decays are pooled before their rms is taken. Raises ParameterError when no decay lasts
    until a start.
    """
    return [_score(motions, estimates, tracking, task, body, at) for body in task.scored for at in task.starts]


def _score(
    motions: Sequence[PlaneMotion],
    estimates: Sequence[Array],
    tracking: Tracking,
    task: ScoringTask,
    body: int,
    start: float,
) -> Score:
    true = np.concatenate([_late(one, one.lateral, start) for one in motions])
    if not len(true):
        raise ParameterError(f"from = {start} s is after the end of every decay")
    found = np.concatenate([_late(one, y, start) for one, y in zip(motions, estimates, strict=True)])
    ratios = fixed_ratios(tracking, task.sensed, body, start)
    outer = max(task.sensed)
    motion = _rms(true[:, body])
    if motion < STILL:
        raise ParameterError(f"score = {body + 1}: this body moves less than {STILL} m from {start} s on")

    def percent(guess: Array) -> float:
        return 100.0 * _rms(guess - true[:, body]) / motion

    return Score(
        body=body + 1,
        from_s=start,
        rms_error_mm=1e3 * _rms(found[:, body] - true[:, body]),
        rms_motion_mm=1e3 * motion,
        percent_of_motion=percent(found[:, body]),
        constant_curvature_percent=percent(constant_curvature(outer, body) * true[:, outer]),
        fixed_ratio_percent=percent(true[:, list(task.sensed)] @ ratios),
    )


def _late(motion: PlaneMotion, values: Array, start: float) -> Array:
    return np.asarray(values[motion.t >= start - SAME])


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
