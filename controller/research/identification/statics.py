"""Joint stiffness by least squares on static deflections (paper, "Parameter Estimation").

Beyond the paper: what pressure adds to it and to the length, a gain of each chamber, and a continuous form of the
actuator, each only if the data bear it.
"""

from dataclasses import replace

import numpy as np
from scipy import stats

from controller.arrays import Array
from controller.errors import DataError, ParameterError
from controller.research.identification.fit import Fit
from controller.research.identification.motion.modal import TRACKING_RATE, tracking_gains
from controller.research.identification.poses import Poses, fine, predict
from controller.research.identification.regression import Solution, solve
from controller.research.identification.report.static_plots import marker_misfits, outlier_notes, static_plots
from controller.research.identification.static_form import SHAPES, Shape, StaticForm
from controller.schema.actuator import ROUNDING, Actuator, Tracking

SCAN = np.logspace(-1.5, 1.5, 31)
"""Factors on the base's stiffness that are tried first: far from the truth the body curls, and has other minima."""
CERTAIN = 0.999
"""With which what a form has more must explain more than chance does (F-test)."""
WORTH = 0.1
"""By which share the squares must fall besides: of a body that is known to the noise nothing is gained."""


def fit_statics(poses: Poses, base: Actuator, shape: str = "auto", *, robust: bool = False) -> Fit:
    """Stiffness of `base` that puts its static poses nearest to the measured markers, in metres.

    Unknown is its logarithm, so that it stays positive; `robust` weighs values down that lie far out (soft L1).
    """
    level = poses.level.max(axis=0)
    form = StaticForm(base, chosen_shape(base, shape), (float(level[0]), float(level[1])))
    factor = min(SCAN, key=lambda factor: _squares(form, form.start(factor), poses))
    solution = _solved(form, form.start(float(factor)), poses, robust)
    while better := _better(form, solution, poses, robust):
        form, solution = better
    actuator = driveable(_observable(form.actuator(solution.x), poses), base)
    return Fit(
        title="Stiffness from static deflections",
        method=_method(poses, actuator, form, robust),
        actuator=actuator,
        parameters=form.estimates(solution),
        misfits=marker_misfits(poses, solution.residual),
        plots=static_plots(poses, actuator, solution.residual),
        notes=(*_by_rods_note(actuator, poses), *outlier_notes(poses, solution.residual, robust)),
    )


def _observable(actuator: Actuator, poses: Poses) -> Actuator:
    """With what `tendril observe` needs besides, where the base says none of it: the markers' frame, and gains."""
    K_o, B_o = tracking_gains(actuator, TRACKING_RATE)
    frame = Tracking(base=(0.0, 0.0), axis=(1.0, 0.0), arcs=tuple(poses.arcs.tolist()))
    tracking = actuator.tracking or frame
    if any(tracking.K_o):
        return actuator
    return actuator.model_copy(update={"tracking": tracking.model_copy(update={"K_o": K_o, "B_o": B_o})})


def driveable(actuator: Actuator, base: Actuator) -> Actuator:
    """`actuator` with the u_max for which it needs the same pressure as `base` does for its own."""
    if actuator.pressure_map == base.pressure_map:
        return actuator
    u_max = base.u_max * max(base.pressure_map) / max(actuator.pressure_map)
    return actuator.model_copy(update={"u_max": (1.0 - ROUNDING) * u_max})


def _by_rods_note(actuator: Actuator, poses: Poses) -> tuple[str, ...]:
    """What it costs that the chambers of a body by EI end at rods of its table, where they do."""
    if actuator.EI is None or actuator.chamber_arcs is not None:
        return ()
    (b1, e1), (b2, e2) = (np.array(actuator.chambers) * actuator.length / actuator.table_rods).round(6).tolist()
    by_arcs = actuator.model_copy(update={"chamber_arcs": ((b1, e1), (b2, e2))})
    off = np.hypot(*np.moveaxis(predict(by_arcs, poses) - predict(actuator, poses), -1, 0))
    return (
        f"chambers are given by rods, which puts the markers of these poses up to {1e3 * off.max():.1f} mm from where "
        f"they are with chamber_arcs = [[{b1:g}, {e1:g}], [{b2:g}, {e2:g}]]: with EI, give those",
    )


def chosen_shape(base: Actuator, name: str) -> Shape:
    """The shape of this name; `auto` keeps the kind of profile that the base actuator has."""
    for shape in SHAPES:
        if name == shape:
            return shape
    if name != "auto":
        raise ParameterError(f"profile = {name!r} is not one of auto, {', '.join(SHAPES)}")
    return SHAPES[min(len(base.EI or base.k), len(SHAPES)) - 1]


def _better(form: StaticForm, solution: Solution, poses: Poses, robust: bool) -> tuple[StaticForm, Solution] | None:
    """Of the forms that have more, the best that is worth it, with its solution; None where none is."""
    found = []
    for richer in _richer(form, poses):
        more = _more(richer, richer.start_from(form, solution.x), poses, robust)
        if more is not None and _is_worth(more, solution) and richer.is_possible(more.x):
            found.append((richer, more))
    return min(found, key=lambda one: float(one[1].residual @ one[1].residual), default=None)


def _more(form: StaticForm, start: Array, poses: Poses, robust: bool) -> Solution | None:
    """The solution of a richer form; None where the data leave one of its unknowns free."""
    try:
        return _solved(form, start, poses, robust)
    except DataError:
        return None


def _richer(form: StaticForm, poses: Poses) -> list[StaticForm]:
    """What else might be fitted: what pressure adds, gains of the chambers, a backbone that begins at the clamp."""
    pressed = poses.by_chamber and min(form.level) > 0.0
    (begin, first), (second, end) = form.base.chambers
    meet = begin == 0 and first == second and end == form.base.table_rods
    by_table = form.base.EI is None and form.base.chamber_arcs is None
    all_used = bool((poses.chambers.max(axis=0) > 0.0).all())
    by_arcs = meet and by_table and form.shape != "scaled" and len(poses.arcs) > 1
    return [
        *([replace(form, stiffens=True)] if pressed and not form.stiffens else []),
        *([replace(form, stretches=True)] if pressed and not form.stretches else []),
        *([replace(form, uneven=True)] if all_used and not form.uneven else []),
        *([replace(form, continuous=True)] if by_arcs and not form.continuous else []),
    ]


def _is_worth(richer: Solution, form: Solution) -> bool:
    """Whether a form that has more unknowns explains more than that alone does."""
    values, more = richer.residual.size, richer.x.size - form.x.size
    squares, less = float(form.residual @ form.residual), float(richer.residual @ richer.residual)
    if less > (1.0 - WORTH) * squares:
        return False
    if more <= 0:
        return True
    left = values - richer.x.size
    return (squares - less) / more > float(stats.f.ppf(CERTAIN, more, left)) * less / left


def _method(poses: Poses, actuator: Actuator, form: StaticForm, robust: bool) -> str:
    shapes = {"uniform": "One stiffness everywhere", "linear": "Stiffness linear from base to tip"}
    added = ", to which each pair's pressures add a share where it reaches" if form.stiffens else ""
    added += ", with rods that they lengthen there" * form.stretches + ", and a gain of each chamber" * form.uneven
    where = "on a backbone that begins at the clamp, with chambers that meet where they fit best, " * form.continuous
    slopes = ", ".join(f"{slope:.4g}" for slope in actuator.pressure_map)
    return (
        f"{shapes.get(form.shape, 'The stiffness profile of the base file times one factor')}{added}, {where}fitted by "
        f"least squares{' with a soft L1 loss' if robust else ''} to {poses.points.shape[1]} markers in "
        f"{len(poses.points)} static poses on a chain of {fine(actuator)} rods; torques follow from pressures by "
        f"pressure_map = ({slopes}) Pa/(N m). Intervals: s^2 (J^T J)^-1, Student's t."
    )


def _solved(form: StaticForm, start: Array, poses: Poses, robust: bool) -> Solution:
    return solve(lambda x: _residual(form, x, poses), start, robust=robust)


def _residual(form: StaticForm, x: Array, poses: Poses) -> Array:
    return (predict(form.actuator(x), poses) - poses.points).ravel()


def _squares(form: StaticForm, x: Array, poses: Poses) -> float:
    """Sum of squares; infinite where gravity leaves so soft a body no pose."""
    try:
        return float(np.square(_residual(form, x, poses)).sum())
    except ParameterError:
        return float("inf")
