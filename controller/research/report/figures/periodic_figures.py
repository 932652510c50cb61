"""Tasks 2 and 3: periodic references over time and in the plane."""

from functools import partial
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from controller.arrays import Mask
from controller.research.experiments.paper_rows import window_of
from controller.research.experiments.results import Finished, Results
from controller.research.report.figures.look import MM, OBSERVER, REFERENCE, TIP, in_plane, key, over_time, plane
from controller.research.report.figures.plate import TALL, Panel, Plate, panel, plate_of
from controller.research.report.spans import last_cycles, once
from controller.simulation.metrics import Window

CYCLES = 4
"""Last cycles that are drawn in the plane."""
ZOOM = (8.1, 8.4)
"""Times of the paper's closer look at y [s]."""


def tracking_plate(results: Results, reference: str, actuator: str, what: str) -> Plate:
    """x and y over time, and the last cycles."""
    caption = f"{what}, {actuator} under FF+PI. Left: x and y over time. Right: the last {CYCLES} cycles in the plane."
    return plate_of(results, reference, actuator, caption, _tracking)


def circle_plate(results: Results) -> Plate:
    """The circle at 1 Hz of P1, with the paper's closer look at y."""
    caption = (
        f"Circle of 60 mm at 1 Hz, P1 under FF+PI: x and y over time, the last {CYCLES} cycles in the plane, and "
        f"closer looks at both coordinates from {ZOOM[0]} to {ZOOM[1]} s."
    )
    return plate_of(results, "circle_1hz", "P1", caption, lambda run: (*_tracking(run), *_zooms(run)))


def _tracking(run: Finished) -> tuple[Panel, ...]:
    name = run.case.reference
    return (
        panel(f"{name}: x and y over time", partial(_draw_axes, run), TALL),
        panel(f"{name}: path of the last cycles", partial(_draw_cycles, run), TALL),
    )


def _zooms(run: Finished) -> tuple[Panel, ...]:
    name = run.case.reference
    return tuple(panel(f"{name}: {'xy'[axis]}, closer", partial(_draw_zoom, run, axis)) for axis in (1, 0))


def _draw_axes(run: Finished, figure: Figure) -> None:
    above, below = figure.subplots(2, sharex=True)
    for axis, axes in enumerate((above, below)):
        _curves(axes, run, axis, run.trace.t >= 0.0)
        axes.set_title(_lag(run, "xy"[axis]))
    below.set_xlabel("time [s]")
    key(figure, above)


def _draw_zoom(run: Finished, axis: int, figure: Figure) -> None:
    axes, t = figure.add_subplot(), run.trace.t
    _curves(axes, run, axis, (t >= ZOOM[0] - 1e-9) & (t <= ZOOM[1] + 1e-9))
    axes.set_xlabel("time [s]")
    key(figure, axes)


def _curves(axes: Axes, run: Finished, axis: int, shown: Mask) -> None:
    """Tip, observer and reference along one axis."""
    trace = run.trace
    for p, look, label in ((trace.tip, TIP, "tip (twin)"), (trace.p_hat, OBSERVER, "observer")):
        over_time(axes, trace.t[shown], p[shown, axis] * MM, look, label)
    over_time(axes, trace.t[shown], trace.p_ref[shown, axis] * MM, REFERENCE, "reference")
    axes.set_ylabel(f"{'xy'[axis]} [mm]")


def _draw_cycles(run: Finished, figure: Figure) -> None:
    axes, trace = figure.add_subplot(), run.trace
    shown = last_cycles(run, CYCLES)
    looks: tuple[tuple[Any, Mask, Any, str], ...] = (
        (trace.tip, shown, TIP, "tip (twin)"),
        (trace.p_hat, shown, OBSERVER, "observer"),
        (trace.p_ref, once(run), REFERENCE, "reference"),
    )
    for p, rows, look, label in looks:
        in_plane(axes, p[rows], look, label)
    window = window_of(run.case.reference)
    plane(axes, f"RMSE {run.metrics[window]['rmse']:.1f} mm ({window})")
    key(figure, axes)


def _lag(run: Finished, axis: str) -> str:
    """The phase in words; nothing where an axis has none."""
    lag = run.metrics[Window.AFTER_APPROACH].get(f"lag_deg_{axis}")
    if lag is None:
        return ""
    return f"{axis} lags by {round(lag)} deg" if round(lag) >= 0 else f"{axis} leads by {-round(lag)} deg"
