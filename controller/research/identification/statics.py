"""Joint stiffness by least squares on static deflections (paper, "Parameter Estimation")."""

from typing import Literal, get_args

import numpy as np

from controller.arrays import Array
from controller.errors import ParameterError
from controller.research.identification.fit import Estimate, Fit
from controller.research.identification.poses import Poses, fine, predict
from controller.research.identification.regression import Solution, exponential, solve
from controller.research.identification.report.static_plots import marker_misfits, outlier_notes, static_plots
from controller.schema.actuator import Actuator

Shape = Literal["uniform", "linear", "scaled"]
"""Profile of k: one value, two ends of a line, or the base actuator's own profile times one factor."""

SHAPES: tuple[Shape, ...] = get_args(Shape)

SCAN = np.logspace(-1.5, 1.5, 31)
"""Factors on the base's stiffness that are tried first: far from the truth the body curls, and has other minima."""


def fit_statics(poses: Poses, base: Actuator, shape: str = "auto", *, robust: bool = False) -> Fit:
    """Stiffness profile of `base` that puts its static poses nearest to the measured markers, in metres.

    Unknown is ln k, so that k stays positive; `robust` weighs values down that lie far out (soft L1).
    """
    kind = chosen_shape(base, shape)
    start = _start(base, poses, kind)
    solution = solve(lambda x: _residual(with_stiffness(base, kind, x), poses), start, robust=robust)
    actuator = with_stiffness(base, kind, solution.x)
    return Fit(
        title="Stiffness from static deflections",
        method=_method(poses, actuator, kind, robust),
        actuator=actuator,
        parameters=_estimates(base, kind, solution),
        misfits=marker_misfits(poses, solution.residual),
        plots=static_plots(poses, actuator, solution.residual),
        notes=outlier_notes(poses, solution.residual, robust),
    )


def chosen_shape(base: Actuator, name: str) -> Shape:
    """The shape of this name; `auto` keeps the kind of profile that the base actuator has."""
    for shape in SHAPES:
        if name == shape:
            return shape
    if name != "auto":
        raise ParameterError(f"profile = {name!r} is not one of auto, {', '.join(SHAPES)}")
    return SHAPES[min(len(base.k), len(SHAPES)) - 1]


def with_stiffness(base: Actuator, shape: Shape, x: Array) -> Actuator:
    """`base` with the stiffness that the unknowns ln k (p,) mean."""
    k = tuple(np.exp(x).tolist())
    return base.model_copy(update={"k": tuple(k[0] * value for value in base.k) if shape == "scaled" else k})


def _method(poses: Poses, actuator: Actuator, shape: Shape, robust: bool) -> str:
    form = {"uniform": "One stiffness for all joints", "linear": "Stiffness linear from base to tip joint"}
    slopes = ", ".join(f"{slope:.4g}" for slope in actuator.pressure_map)
    return (
        f"{form.get(shape, 'The stiffness profile of the base file times one factor')}, fitted by least squares"
        f"{' with a soft L1 loss' if robust else ''} to {poses.points.shape[1]} markers in {len(poses.points)} static "
        f"poses on a chain of {fine(actuator)} rods; torques follow from pressures by pressure_map = ({slopes}) "
        "Pa/(N m). Intervals: s^2 (J^T J)^-1, Student's t."
    )


def _residual(actuator: Actuator, poses: Poses) -> Array:
    return (predict(actuator, poses) - poses.points).ravel()


def _squares(actuator: Actuator, poses: Poses) -> float:
    """Sum of squares; infinite where gravity leaves so soft a body no pose."""
    try:
        return float(np.square(_residual(actuator, poses)).sum())
    except ParameterError:
        return float("inf")


def _start(base: Actuator, poses: Poses, shape: Shape) -> Array:
    """Best of SCAN, as unknowns of `shape`."""
    factor = float(min(SCAN, key=lambda factor: _squares(with_stiffness(base, "scaled", np.log([factor])), poses)))
    values = {"uniform": [np.mean(base.k)], "linear": [base.k[0], base.k[-1]], "scaled": [1.0]}[shape]
    return np.log(factor * np.array(values))


def _estimates(base: Actuator, shape: Shape, solution: Solution) -> tuple[Estimate, ...]:
    names = {"uniform": ["k"], "linear": ["k, base joint", "k, tip joint"], "scaled": ["k / k of the base file"]}[shape]
    unit = "1" if shape == "scaled" else "N m/rad"
    found = [exponential(name, unit, solution, np.eye(len(names))[i]) for i, name in enumerate(names)]
    if shape == "linear":
        found.append(exponential("taper, k tip / k base", "1", solution, np.array([-1.0, 1.0])))
    return tuple(found)
