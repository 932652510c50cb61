"""How well the tip followed: the paper's measures of error, as functions of a run's telemetry and its reference.

Formulas take errors (n,2) [m] and give SI. `measure` gives all of them for one window, in the units of the paper.
"""

import math
from collections.abc import Callable
from enum import StrEnum
from itertools import pairwise

import numpy as np

from controller.arrays import Array, Rows
from controller.errors import DataError
from controller.reference.reference import Reference
from controller.schema.parameters import DT

SETTLED = 0.1
"""Share of a step, at its end, in which its steady-state error is taken (paper, "final 10% of each step interval")."""
SWING_MIN = 1e-3
"""An axis that swings less than this has no phase [m]."""
SEEN_MIN = 0.9
"""There is no phase where the tip was seen in a smaller share of the rows."""
UNITS = {
    "rmse": ("mm", 1e3),
    "sse": ("mm", 1e3),
    "ise": ("mm^2 s", 1e6),
    "step_spread": ("mm", 1e3),
    "max_x": ("mm", 1e3),
    "max_y": ("mm", 1e3),
    "lag_deg_x": ("deg", 1.0),
    "lag_deg_y": ("deg", 1.0),
    "observer_rmse": ("mm", 1e3),
    "feedback_share": ("1", 1.0),
    "reduction": ("%", 1e2),
}
"""Every metric: the unit in which it is reported, and how many of it are one of the formula's. `reduction` is of two
runs: by how much the RMSE of one is below that of the other."""


class Window(StrEnum):
    """Which part of a run is measured."""

    WHOLE = "whole run"
    """Approach included (paper, P3 at 2 Hz: "RMSE for the entire 6 sec run")."""
    AFTER_APPROACH = "after the approach"


def true_tip(rows: Rows) -> Array:
    """Tip of the twin (n,2) [m] at every tick, free of the camera's noise and age; nan on hardware."""
    return rows["twin_backbone"][:, -1].astype(np.float64)


def tip(rows: Rows) -> Array:
    """The tip that is judged (n,2) [m]: the twin's true one, on hardware the measured one."""
    true = true_tip(rows)
    return true if np.isfinite(true).all() else rows["p_meas"]


def rmse(e: Array) -> float:
    """Root of the mean squared length of e (n,2) [m]: the 2-D norm, as the paper's RMSE and ISE agree on."""
    return math.sqrt(float(np.mean(np.sum(e**2, axis=1))))


def ise(e: Array, dt: float = DT) -> float:
    """Integral of the squared length of e (n,2) [m^2 s] (paper, "ISE")."""
    return float(np.sum(e**2)) * dt


def sse(e: Array) -> float:
    """Mean length of e (n,2) over its last tenth [m] (paper, "SSE")."""
    settled = e[-max(1, round(SETTLED * len(e))) :]
    return float(np.mean(np.linalg.norm(settled, axis=1)))


def over_steps(measure_one: Callable[[Array], float], e: Array, steps: tuple[int, ...]) -> float:
    """Mean of a measure of e (n,2) over the steps that begin at the ticks `steps`, as the paper averages its steps."""
    return float(np.mean([measure_one(e[begin:end]) for begin, end in pairwise((*steps, len(e)))]))


def step_spread(mean_square: float, mean: float) -> float:
    """Standard deviation of the steps' RMSE over the steps, from the mean of their squares and their mean.

    The mean square is the ISE over the duration of a step: this is what the paper's ISE says beyond its RMSE. In their
    unit, and its square.
    """
    return math.sqrt(max(0.0, mean_square - mean**2))


def reduction(before: float, after: float) -> float:
    """By which share the RMSE `after` is below that `before` (paper, Task 4)."""
    return 1.0 - after / before


def swing(p: Array, frequency: float, dt: float = DT) -> complex:
    """Phasor a of the least-squares sine c + Re(a exp(2 pi i f t)) through p (n,), in the unit of p; t = 0 at p[0]."""
    angle = 2.0 * math.pi * frequency * dt * np.arange(len(p))
    basis = np.stack([np.ones(len(p)), np.cos(angle), np.sin(angle)], axis=1)
    _, a, b = np.linalg.lstsq(basis, p, rcond=None)[0]
    return complex(a, -b)


def lag_deg(p_ref: Array, p: Array, frequency: float, dt: float = DT) -> float:
    """By how much p (n,) [m] lags behind p_ref (n,) at `frequency` [Hz], in (-180, 180] degrees.

    nan where there is no phase: less than one period, or one of the two swings less than SWING_MIN.
    """
    if len(p) * frequency * dt < 1.0 - 1e-9:
        return math.nan
    a_ref, a = swing(p_ref, frequency, dt), swing(p, frequency, dt)
    if min(abs(a_ref), abs(a)) < SWING_MIN:
        return math.nan
    ratio = a_ref / a
    return math.degrees(math.atan2(ratio.imag, ratio.real))


def feedback_share(u_ff: Array, u_fb: Array) -> float:
    """Share of the feedback in the command: mean |u_fb| / mean (|u_ff| + |u_fb|), lengths of torques (n,2) [N m].

    The paper calls it the "mean corrective feedback contribution ... of the total commanded input" and gives no
    formula. A ratio of means, because the ratio at one tick means nothing where the whole command passes zero.
    """
    ff, fb = (float(np.mean(np.linalg.norm(u, axis=1))) for u in (u_ff, u_fb))
    return fb / (ff + fb) if ff + fb > 0.0 else 0.0


def measure(rows: Rows, reference: Reference, window: Window) -> dict[str, float]:
    """Metrics of a run in the unit of UNITS; one that does not apply (no steps, no period, no twin) is left out.

    `rows` (n,) are aligned to the reference's. After the approach, errors of a stepped reference are taken over each
    step and averaged; its largest errors are of all steps. Phase is always taken after the approach, where it exists.
    Raises DataError if there are not as many rows as the reference has.
    """
    if len(rows) != len(reference.p):
        raise DataError(f"{reference.name}: {len(rows)} rows of telemetry for {len(reference.p)} of the reference")
    begin = 0 if window is Window.WHOLE else reference.start
    actual, part = tip(rows), rows[begin:]
    observed = part["p_hat"] - true_tip(part)
    si = {
        **errors(reference.p - actual, reference, window),
        **lags(reference, actual),
        "observer_rmse": rmse(observed),
        "feedback_share": feedback_share(part["u_ff"], part["u_fb"]),
    }
    return {metric: value * UNITS[metric][1] for metric, value in si.items() if math.isfinite(value)}


def errors(e: Array, reference: Reference, window: Window) -> dict[str, float]:
    """rmse, ise, sse, spread of the steps and largest errors of e (n,2) [m], the whole run's, in `window`; SI."""
    part = e if window is Window.WHOLE else e[reference.start :]
    max_x, max_y = (float(value) for value in np.abs(part).max(axis=0))
    found = {"rmse": rmse(part), "ise": ise(part), "max_x": max_x, "max_y": max_y}
    if reference.steps:
        mean_square, mean = (over_steps(one, e, reference.steps) for one in (lambda step: rmse(step) ** 2, rmse))
        found |= {"sse": over_steps(sse, e, reference.steps), "step_spread": step_spread(mean_square, mean)}
        if window is Window.AFTER_APPROACH:
            found |= {"rmse": over_steps(rmse, e, reference.steps), "ise": over_steps(ise, e, reference.steps)}
    return found


def lags(reference: Reference, actual: Array, dt: float = DT) -> dict[str, float]:
    """Phase lag of both axes [deg] of the tip `actual` (n,2) [m] after the approach to a periodic reference.

    Rows are dt [s] apart. Each axis has its phase at its own frequency.
    """
    if reference.frequency is None:
        return {}
    p_ref, p = reference.p[reference.start :], actual[reference.start :]
    both = reference.axis_frequencies or (reference.frequency,) * 2
    return {f"lag_deg_{axis}": lag_deg(p_ref[:, j], p[:, j], both[j], dt) for j, axis in enumerate(("x", "y"))}


def phase_lags(p_ref: Array, p: Array, frequencies: tuple[float, float], dt: float) -> dict[str, float]:
    """Phase lag of both axes [deg] of the path p (n,2) [m], nan where it was not seen, behind p_ref (n,2).

    Left out where there is no phase. `frequencies` are those of x and y [Hz], rows are dt [s] apart.
    """
    wanted = Reference("", p_ref, 0, frequency=1.0, axis_frequencies=frequencies)
    actual = mended(p)
    found = {} if actual is None else lags(wanted, actual, dt)
    return {name: lag for name, lag in found.items() if math.isfinite(lag)}


def mended(p: Array) -> Array | None:
    """The path p (n, 2) [m] with straight lines where it is nan; None where too much of it is."""
    rows, seen = np.arange(len(p)), np.isfinite(p).all(axis=1)
    if not len(p) or np.mean(seen) < SEEN_MIN:
        return None
    return np.column_stack([np.interp(rows, rows[seen], p[seen, j]) for j in range(2)])
