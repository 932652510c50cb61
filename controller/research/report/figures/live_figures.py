"""Task 5: a user's path, live."""

from functools import partial

from matplotlib.figure import Figure

from controller.research.experiments.results import Finished, Results
from controller.research.report.figures.look import MM, REFERENCE, TIP, in_plane, key, over_time, plane
from controller.research.report.figures.plate import TALL, Panel, Plate, panel, plate_of
from controller.simulation.metrics import Window


def live_plate(results: Results) -> Plate:
    """The projected marker and the tip, in the plane and over time."""
    caption = (
        "Task 5: a path drawn in the browser, projected onto the reach and followed live, P1 under FF+PI: inverse "
        "at 100 Hz, no velocity feedforward."
    )
    return plate_of(results, "live_path", "P1", caption, _panels)


def _panels(run: Finished) -> tuple[Panel, ...]:
    return (
        panel("live path: x and y over time", partial(_draw_axes, run), TALL),
        panel("live path in the plane", partial(_draw_path, run), TALL),
    )


def _draw_path(run: Finished, figure: Figure) -> None:
    axes, trace = figure.add_subplot(), run.trace
    in_plane(axes, trace.tip, {**TIP, "linewidth": 1.4}, "tip (twin)")
    in_plane(axes, trace.p_ref, {**REFERENCE, "linewidth": 0.9}, "projected marker")
    plane(axes, f"RMSE {run.metrics[Window.WHOLE]['rmse']:.1f} mm")
    key(figure, axes)


def _draw_axes(run: Finished, figure: Figure) -> None:
    above, below = figure.subplots(2, sharex=True)
    trace = run.trace
    for axis, axes in enumerate((above, below)):
        over_time(axes, trace.t, trace.tip[:, axis] * MM, TIP, "tip (twin)")
        over_time(axes, trace.t, trace.p_ref[:, axis] * MM, REFERENCE, "projected marker")
        axes.set_ylabel(f"{'xy'[axis]} [mm]")
    below.set_xlabel("time [s]")
    key(figure, above)
