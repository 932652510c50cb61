"""Least squares over whole decays: which shape of the model predicts the inner bodies best from the last one."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy import stats
from scipy.optimize import least_squares

from controller.arrays import Array
from controller.errors import ParameterError
from controller.research.identification.motion.modal import LATE, Form, IdentifiedBody, Shape
from controller.research.identification.offline import estimate, in_plane, offline_observer
from controller.research.identification.plane import PlaneMotion

FITTED = 1.5
"""Time after the first sample that is fitted [s]: the rest is noise."""
START = Shape(taper=0.0, load=0.7, stiff=0.0, delay=0.05, fade=-3.2, hold=-1.2, slope=0.0)
SPREAD = Shape(taper=1.5, load=0.3, stiff=1.5, delay=0.05, fade=0.5, hold=1.0, slope=1.0, cos2=0.15, sin2=0.15)
"""What is expected before any data, and how widely. Two tapers are apart only as far as decays insist: a few decays in
a few planes would be met by any, and the trunk's left-out decays are predicted as well from 0.15 as from 0.7."""
BELIEF = 0.03
"""Weight of that expectation, beside errors of about 0.3 for each decay."""
MEASURED = 0.05
"""Weight of the first mode's ratios, each off by one standard error. Where decays agree they decide the taper: marker
noise that the observer's springs pass on would draw it; where decays differ much, the observer's errors decide."""
FAILED = 3.0
"""Error of a shape that no model can have."""
EVALUATIONS = 60
DIFF_STEP = 2e-3
"""Of the finite differences, far above what the search for the held pose leaves open."""
SETTLED = 1e-4
"""Relative change of the cost and of the unknowns at which the search ends."""
LIMIT = 5.0
"""Unknowns stay within this many spreads of what is expected."""


class Found(NamedTuple):
    """The fitted shape and the covariance of its `unknowns`."""

    shape: Shape
    covariance: Array
    t: float
    """Half-width of a 95 % confidence interval per standard error; 0 for one decay, which has no spread."""
    settled: bool
    """Whether the search moved and came to an end by itself; if not, covariance and interval mean nothing."""
    cost: float
    """Half the sum of squares."""


def fit_shape(motions: Sequence[PlaneMotion], body: IdentifiedBody) -> Found:
    """Least squares of `errors`, drawn a little to the first mode's ratios and the expected shape."""
    motions = [_cut(one) for one in motions]
    begin, free = body.start(START), unknowns(body.form)
    start, spread = (np.array([getattr(one, name) for name in free]) for one in (begin, SPREAD))

    def shape_of(z: Array) -> Shape:
        return begin._replace(**dict(zip(free, (start + spread * z).tolist(), strict=True)))

    def residual(z: Array) -> Array:
        shape = shape_of(z)
        return np.concatenate([*errors(motions, body, shape), MEASURED * body.ratios_off(shape), BELIEF * z])

    delay = np.array(free) == "delay"
    low = np.where(delay, -start / spread, -LIMIT)
    found = least_squares(
        residual,
        np.zeros(start.size),
        bounds=(low, LIMIT),
        diff_step=[DIFF_STEP] * start.size,
        ftol=SETTLED,
        xtol=SETTLED,
        max_nfev=EVALUATIONS,
    )
    shape = shape_of(found.x)
    sizes = [rows.size for rows in errors(motions, body, shape)]
    alone = np.full(found.fun.size - sum(sizes) - start.size, MEASURED)
    off = np.concatenate([found.fun[: sum(sizes)], alone, np.full(start.size, BELIEF)])
    covariance = clustered(np.asarray(found.jac), off, sizes) * np.outer(spread, spread)
    t = float(stats.t.ppf(0.975, len(sizes) - 1)) if len(sizes) > 1 else 0.0
    return Found(shape, covariance, t, found.status > 0 and bool(np.any(found.x != 0.0)), float(found.cost))


def unknowns(form: Form) -> tuple[str, ...]:
    """The fields of Shape that are fitted."""
    return tuple(name for name in Shape._fields if form.directional or name not in ("cos2", "sin2"))


def at_limit(shape: Shape, field: str) -> bool:
    """True when this unknown ended where its search ends."""
    off = getattr(shape, field) - getattr(START, field)
    return bool(abs(off) > 0.99 * LIMIT * getattr(SPREAD, field))


def errors(motions: Sequence[PlaneMotion], body: IdentifiedBody, shape: Shape) -> list[Array]:
    """For each decay the errors of the inner bodies' lateral motion, whole and late, over the norm of that motion.

    So every decay counts the same, however far it swings.
    """
    try:
        actuator = body.shaped(shape)
        bodies = motions[0].moved.shape[1]
        tip = [bodies - 1]
        observers = [offline_observer(in_plane(actuator, one.direction), tip) for one in motions]
        return [_error(one, estimate(offline, one)[..., 1]) for offline, one in zip(observers, motions, strict=True)]
    except ParameterError:
        return [np.full_like(_error(one, one.lateral), FAILED / np.sqrt(one.t.size)) for one in motions]


def clustered(J: Array, r: Array, sizes: Sequence[int]) -> Array:
    """Covariance (p,p) of a least squares solution whose errors r hang together within clusters of `sizes` rows.

    H^-1 (sum of g g^T) H^-1 with one gradient g = J^T r per cluster: the samples of one decay are no independent data.
    Rows after the last cluster are independent.
    """
    inverse = np.linalg.inv(J.T @ J)
    ends = np.cumsum(sizes)
    gradients = [J[end - size : end].T @ r[end - size : end] for size, end in zip(sizes, ends, strict=True)]
    few = len(sizes) / max(1, len(sizes) - 1)
    alone = J[ends[-1] :] * r[ends[-1] :, None]
    return np.asarray(inverse @ (few * sum(np.outer(g, g) for g in gradients) + alone.T @ alone) @ inverse)


def _error(motion: PlaneMotion, lateral: Array) -> Array:
    rows = []
    for start in (0.0, LATE):
        late = motion.t >= start
        true = motion.lateral[late, :-1]
        norm = float(np.linalg.norm(true))
        if norm > 0.0:
            off = np.nan_to_num((lateral[late, :-1] - true).ravel() / norm, nan=FAILED)
            rows.append(np.clip(off, -FAILED, FAILED))
    return np.concatenate(rows) if rows else np.zeros(0)


def _cut(motion: PlaneMotion) -> PlaneMotion:
    keep = motion.t <= motion.t[0] + FITTED
    return PlaneMotion(motion.id, motion.t[keep], motion.moved[keep], motion.outside, motion.direction)
