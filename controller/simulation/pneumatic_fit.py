"""Dead time and lag of a rig's pneumatics from steps of pressure in one chamber after another.

A chamber is taken to follow its setpoint p_set, `dead_time` earlier, by a first-order lag, as the observer has it:

    dp/dt = (p_set(t - dead_time) - p) / tau,    shown = offset + gain p

once with one tau, and once with one for filling (p_set > p) and one for exhausting. Dead time and lags are those of all
chambers; offset and gain are each chamber's own, by linear least squares (variable projection). Samples far out count
less (soft L1). The intervals hold the steps, not the samples, for independent: what the model leaves over is alike from
one sample to the next. Paper, "Dynamic observer": 50 ms and 50 ms, unmeasured; the fit is ours.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from controller.arrays import Array
from controller.errors import ParameterError
from controller.schema.parameters import ControllerParameters
from controller.simulation.lag import lagged

STEP_LEAST = 5e3
"""A setpoint that moves by less is no step [Pa]."""
FOLLOWS_LEAST = 0.5
"""A chamber whose reading moves by less than this share of its setpoint does not follow it."""
STEPS_LEAST = 4
"""Of all chambers together."""
STARTS = [(dead_time, lag) for dead_time in (0.005, 0.03, 0.08) for lag in (0.02, 0.06, 0.2)]
"""Where the search begins: the best of these [s]."""
LAG_LEAST = 1e-3
SCALE_LEAST = 200.0
"""Residuals below this always count in full [Pa]."""
CONFIDENCE = 0.95
EPSILON = 1e-4
"""Step of the finite differences by which intervals are found [s]."""


class ChamberSteps(NamedTuple):
    """What one chamber was asked for and showed, evenly spaced, while steps were commanded to it alone."""

    asked: Array
    """(n,) setpoint [Pa]."""
    shown: Array
    """(n,) measured [Pa]; nan where there was none."""
    starts: tuple[int, ...]
    """Rows at which its setpoint begins to move; each step goes on to the next, the last one to the end."""


class Estimate(NamedTuple):
    """A number with its 95 % interval."""

    value: float
    low: float
    high: float


class PneumaticFit(NamedTuple):
    """What was found."""

    dead_time: Estimate
    """With one lag for both ways [s]."""
    lag: Estimate
    """The same for both ways [s]."""
    inflate: Estimate
    exhaust: Estimate
    """Apart [s]."""
    residual: float
    """Of the model with one lag, rms [Pa]."""
    gains: tuple[float, ...]
    """What each chamber shows at rest, as a share of what it was asked for."""
    offsets: tuple[float, ...]
    """What each shows at zero [Pa]."""
    model: tuple[Array, ...]
    """(n,) of each chamber: what the model with one lag would have shown [Pa]."""


def fit_pneumatics(chambers: Sequence[ChamberSteps], dt: float) -> PneumaticFit:
    """Dead time and lags of `chambers`, sampled every `dt` [s].

    Raises ParameterError where the steps do not tell them: too few, small, not followed, or slower than allowed.
    """
    _require_steps(chambers)
    most = np.array([_most("dead_time"), _most("pneumatic_lag")])
    start = min(STARTS, key=lambda one: float((_residuals(np.array(one), chambers, dt) ** 2).sum()))
    both = _fitted(np.array(start), most, chambers, dt)
    apart = _fitted(np.array([both[0], both[1], both[1]]), most[[0, 1, 1]], chambers, dt)
    for name, value, bound in (("dead time", both[0], most[0]), ("lag", both[1], most[1])):
        if value > 0.98 * bound:
            raise ParameterError(f"{name} = {value:.3g} s: the controller takes {bound:g} s at most")
    dead_time, lag = _intervals(both, chambers, dt)
    _, inflate, exhaust = _intervals(apart, chambers, dt)
    parts = [_shown(both, one, dt) for one in chambers]
    residual = math.sqrt(float(np.mean(_residuals(both, chambers, dt) ** 2)))
    return PneumaticFit(
        dead_time=dead_time,
        lag=lag,
        inflate=inflate,
        exhaust=exhaust,
        residual=residual,
        gains=tuple(gain for gain, _, _ in parts),
        offsets=tuple(offset for _, offset, _ in parts),
        model=tuple(model for _, _, model in parts),
    )


def filled(asked: Array, theta: Array, dt: float) -> Array:
    """Pressure (n,) [Pa] of a chamber that is asked for `asked` (n,) [Pa]; theta: dead time, lag (or in, out) [s]."""
    rows = np.arange(len(asked), dtype=float)
    late = np.interp(rows - theta[0] / dt, rows, asked)
    inward, outward = (1.0 - math.exp(-dt / tau) for tau in (theta[1], theta[-1]))
    if len(theta) == 2:
        return lagged(late, 1.0 - inward, late[:1])
    p, course = float(late[0]), []
    for p_set in late.tolist():
        p += (p_set - p) * (inward if p_set > p else outward)
        course.append(p)
    return np.array(course)


def _most(name: str) -> float:
    """The upper bound of a parameter of the controller."""
    found: float = next(one.le for one in ControllerParameters.model_fields[name].metadata if hasattr(one, "le"))
    return found


def _require_steps(chambers: Sequence[ChamberSteps]) -> None:
    steps = sum(len(one.starts) for one in chambers)
    if steps < STEPS_LEAST:
        raise ParameterError(f"{steps} steps of pressure: at least {STEPS_LEAST} tell dead time and lag")
    for number, one in enumerate(chambers, 1):
        asked, shown = np.ptp(one.asked), np.nanmax(one.shown) - np.nanmin(one.shown)
        if asked < STEP_LEAST:
            raise ParameterError(f"chamber {number}: its setpoint moved by {asked:.0f} Pa, at least {STEP_LEAST:g} Pa")
        if not shown > FOLLOWS_LEAST * asked:
            text = f"its pressure moved by {shown:.0f} Pa when {asked:.0f} Pa were asked for"
            raise ParameterError(f"chamber {number}: {text}")


def _shown(theta: Array, one: ChamberSteps, dt: float) -> tuple[float, float, Array]:
    """Gain, offset [Pa] and what the model with them shows (n,) [Pa]."""
    p = filled(one.asked, theta, dt)
    seen = np.isfinite(one.shown)
    A = np.column_stack((p, np.ones_like(p)))
    (gain, offset), *_ = np.linalg.lstsq(A[seen], one.shown[seen], rcond=None)
    return float(gain), float(offset), gain * p + offset


def _residuals(theta: Array, chambers: Sequence[ChamberSteps], dt: float) -> Array:
    """Of all samples [Pa], 0 where nothing was measured."""
    parts = [np.nan_to_num(_shown(theta, one, dt)[2] - one.shown) for one in chambers]
    return np.concatenate(parts)


def _fitted(start: Array, most: Array, chambers: Sequence[ChamberSteps], dt: float) -> Array:
    """The theta that leaves least over."""
    rough = _residuals(start, chambers, dt)
    scale = max(SCALE_LEAST, 1.4826 * float(np.median(np.abs(rough))))
    least = np.array([0.0, *[LAG_LEAST] * (len(start) - 1)])
    inside = np.clip(start, least + 1e-6, most - 1e-6)
    found = least_squares(
        _residuals,
        inside,
        bounds=(least, most),
        loss="soft_l1",
        f_scale=scale,
        x_scale=0.02,
        diff_step=[1e-3] * len(start),
        xtol=1e-7,
        ftol=1e-9,
        args=(chambers, dt),
    )
    theta: Array = found.x
    return theta


def _intervals(theta: Array, chambers: Sequence[ChamberSteps], dt: float) -> list[Estimate]:
    """theta with intervals by the scatter from step to step: (J^T J)^-1 sum(g g^T) (J^T J)^-1, g = J^T r of a step."""
    r = _residuals(theta, chambers, dt)
    columns = []
    for i in range(len(theta)):
        up, down = theta.copy(), theta.copy()
        up[i] += EPSILON
        down[i] = max(0.0, down[i] - EPSILON)
        columns.append((_residuals(up, chambers, dt) - _residuals(down, chambers, dt)) / (up[i] - down[i]))
    J = np.column_stack(columns)
    edges, first = [], 0
    for one in chambers:
        edges += [first + start for start in one.starts]
        first += len(one.asked)
    scores = np.array([J[a:b].T @ r[a:b] for a, b in zip(edges, [*edges[1:], len(r)], strict=True)])
    steps, unknowns = len(scores), len(theta) + 2 * len(chambers)  # with each chamber's offset and gain
    inverse = np.linalg.pinv(J.T @ J)
    covariance = inverse @ (scores.T @ scores) @ inverse * steps / max(1, steps - unknowns)
    half = student.ppf(0.5 + CONFIDENCE / 2.0, max(1, steps - unknowns)) * np.sqrt(np.diag(covariance))
    return [Estimate(float(v), max(0.0, float(v - h)), float(v + h)) for v, h in zip(theta, half, strict=True)]
