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
    """One scored body in one window; each percentage is an rms error over the rms motion."""

    body: int
    from_s: float
    rms_error_mm: float
    rms_motion_mm: float
    percent_of_motion: float
    """Of the observer."""
    constant_curvature_percent: float
    fixed_ratio_percent: float | None
    """None where the actuator was identified from no decays, whose ratios these are."""
    mode_shape_percent: float
    """Of the model's first mode, scaled to the outermost sensed body: the observer without its dynamics."""
    own_ratio_percent: float
    """Of the sensed motions times what was best for this very decay: less no fixed shape can have."""


class Scored(NamedTuple):
    """One motion and what is compared with it."""

    motion: PlaneMotion
    estimate: Array
    """Lateral motions (n,bodies) [m] that the observer gives."""
    mode: Array
    """Lateral motions of the bodies in the model's first mode (bodies,)."""
    tracking: Tracking
    """Of the actuator that observed it: its products are those of the identified decays."""


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


def score(scored: Sequence[Scored], task: ScoringTask) -> list[Score]:
    """Each scored body from each start.

    Errors and motions of all decays are pooled before their rms is taken. Raises ParameterError when no decay lasts
    until a start.
    """
    return [_score(scored, task, body, at) for body in task.scored for at in task.starts]


def _score(scored: Sequence[Scored], task: ScoringTask, body: int, start: float) -> Score:
    lasting = [one for one in scored if one.motion.t[-1] >= start - SAME]
    if not lasting:
        raise ParameterError(f"from = {start} s is after the end of every decay")
    off = [_errors(one, task.sensed, body, start) for one in lasting]
    motion = _rms([one["motion"] for one in off])
    if motion < STILL:
        raise ParameterError(f"score = {body + 1}: this body moves less than {STILL} m from {start} s on")

    def percent(name: str) -> float:
        return 100.0 * _rms([one[name] for one in off]) / motion

    return Score(
        body=body + 1,
        from_s=start,
        rms_error_mm=1e3 * _rms([one["observer"] for one in off]),
        rms_motion_mm=1e3 * motion,
        percent_of_motion=percent("observer"),
        constant_curvature_percent=percent("curvature"),
        fixed_ratio_percent=percent("ratio") if all("ratio" in one for one in off) else None,
        mode_shape_percent=percent("mode"),
        own_ratio_percent=percent("own"),
    )


def _errors(one: Scored, sensed: Sequence[int], body: int, start: float) -> dict[str, Array]:
    """The body's lateral motion (n,) [m] from `start` on, and what each prediction gets wrong about it."""
    late, outer = one.motion.t >= start - SAME, max(sensed)
    y = one.motion.lateral[late]
    given, true = y[:, list(sensed)], y[:, body]
    own, *_ = np.linalg.lstsq(given, true, rcond=None)
    found = {
        "motion": true,
        "observer": one.estimate[late, body] - true,
        "curvature": constant_curvature(outer, body) * y[:, outer] - true,
        "mode": one.mode[body] / one.mode[outer] * y[:, outer] - true,
        "own": given @ own - true,
    }
    if one.tracking.starts:
        found["ratio"] = given @ fixed_ratios(one.tracking, sensed, body, start) - true
    return found


def _late(motion: PlaneMotion, values: Array, start: float) -> Array:
    return np.asarray(values[motion.t >= start - SAME])


def _rms(parts: Sequence[Array]) -> float:
    return float(np.sqrt(np.mean(np.square(np.concatenate(parts)))))
