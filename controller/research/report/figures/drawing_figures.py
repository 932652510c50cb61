"""Task 1 and its repeats in Task 3: the ten digits, and VU with its errors."""

from functools import partial
from typing import Any

from matplotlib.figure import Figure

from controller.research.experiments.paper_rows import DIGITS
from controller.research.experiments.results import Finished, Results
from controller.research.report.figures.look import MM, REFERENCE, TIP, in_plane, key, over_time, plane
from controller.research.report.figures.plate import FIFTH, Panel, Plate, first, panel, plate_of, why_missing
from controller.research.report.spans import after_approach
from controller.schema.parameters import DT
from controller.simulation.metrics import Window

DIGIT_BOUND, VU_BOUND = 5.0, 4.0
"""Largest error of any axis in the paper [mm]."""
BOUND: Any = {"color": "#D55E00", "linestyle": (0, (1, 1.5)), "linewidth": 0.9}
HUES = ("#332288", "#882255", "#117733", "#0072B2", "#000000")
ERRORS: Any = (
    {"color": "#0072B2", "linestyle": "-", "linewidth": 1.0},
    {"color": "#882255", "linestyle": (0, (5, 1.5)), "linewidth": 1.0},
)
"""Looks of the errors in x and y."""


def digit_plates(results: Results) -> list[Plate]:
    """Ten small drawings, then the errors of all."""
    runs = {name: run for name in DIGITS if (run := first(results, name))}
    missing = " ".join(why_missing(results, name) for name in DIGITS if name not in runs)
    caption = "Digits in 10 s each, P1 under FF+PI; above each its RMSE after the approach. Axes: x and y [mm]."
    small = tuple(
        panel(f"digit {name[-1]}: path and reference", partial(_draw_digit, name, run), FIFTH)
        for name, run in runs.items()
    )
    plates = [Plate(caption, small, 5, missing)]
    if runs:
        both = tuple(
            panel(f"error in {'xy'[axis]} of all digits", partial(_draw_errors, runs, axis), (3.5, 2.9))
            for axis in range(2)
        )
        plates.append(Plate(f"Errors of all digits; the paper's stay within {DIGIT_BOUND:g} mm (dotted).", both))
    return plates


def vu_plate(results: Results, actuator: str) -> Plate:
    """VU and its errors."""
    bound = VU_BOUND if actuator == "P1" else None
    more = f" The paper's errors stay below {VU_BOUND:g} mm (dotted)." if bound else ""
    caption = f"VU in 25 s, {actuator} under FF+PI, and its errors.{more}"
    return plate_of(results, "vu", actuator, caption, partial(_vu_panels, bound))


def _vu_panels(bound: float | None, run: Finished) -> tuple[Panel, ...]:
    return (
        panel("VU: path and reference", partial(_draw_path, run)),
        panel("VU: errors in x and y", partial(_draw_error, run, bound)),
    )


def _draw_digit(name: str, run: Finished, figure: Figure) -> None:
    axes = figure.add_subplot()
    _path(axes, run)
    plane(axes, name[-1])
    axes.set_title(
        f"{run.metrics[Window.AFTER_APPROACH]['rmse']:.1f} mm", loc="right", fontsize=8.0, fontweight="normal"
    )
    axes.set(xlabel="", ylabel="")
    axes.locator_params(nbins=3)
    axes.margins(0.12)


def _draw_path(run: Finished, figure: Figure) -> None:
    axes = figure.add_subplot()
    _path(axes, run)
    plane(axes, f"RMSE {run.metrics[Window.AFTER_APPROACH]['rmse']:.1f} mm")
    key(figure, axes)


def _path(axes: Any, run: Finished) -> None:
    """Path and reference after the approach."""
    shown = after_approach(run)
    in_plane(axes, run.trace.tip[shown], TIP, "tip (twin)")
    in_plane(axes, run.trace.p_ref[shown], REFERENCE, "reference")


def _draw_errors(runs: dict[str, Finished], axis: int, figure: Figure) -> None:
    axes = figure.add_subplot()
    for i, (name, run) in enumerate(runs.items()):
        t, e = _errors(run)
        look = {"color": HUES[i % 5], "linestyle": "-" if i < 5 else (0, (3, 1.5)), "linewidth": 0.9}
        over_time(axes, t, e[:, axis], look, name[-1])
    _bounds(axes, DIGIT_BOUND)
    axes.set(xlabel="time after the approach [s]", ylabel=f"e_{'xy'[axis]} [mm]")
    key(figure, axes, 5)


def _draw_error(run: Finished, bound: float | None, figure: Figure) -> None:
    axes = figure.add_subplot()
    t, e = _errors(run)
    for axis in range(2):
        over_time(axes, t, e[:, axis], ERRORS[axis], f"e_{'xy'[axis]}")
    if bound:
        _bounds(axes, bound)
    axes.set(xlabel="time after the approach [s]", ylabel="error [mm]")
    key(figure, axes)


def _bounds(axes: Any, bound: float) -> None:
    for value in (-bound, bound):
        axes.axhline(value, **BOUND)


def _errors(run: Finished) -> tuple[Any, Any]:
    """Times (m,) [s] after the approach and errors (m, 2) [mm] of the tip against the wanted path."""
    shown = after_approach(run)
    t = run.trace.t - run.reference.start * DT
    return t[shown], (run.trace.p_ref - run.trace.tip)[shown] * MM
