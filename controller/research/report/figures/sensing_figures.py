"""Task 4: paths under four choices of sensors, and the spread of their normalised errors."""

from functools import partial

import numpy as np
from matplotlib.figure import Figure

from controller.research.experiments.paper_rows import SENSING, SENSING_LAWS
from controller.research.experiments.results import Results, SensedTrajectory
from controller.research.report.figures.look import LAW_NAMES, LAWS, REFERENCE, in_plane, key, plane
from controller.research.report.figures.plate import TALL, Plate, first, panel, why_missing
from controller.research.report.spans import after_approach, once

NAMES = {
    "sensing_sweep": "sweep",
    "sensing_circle": "circle of 60 mm at 0.25 Hz",
    "sensing_vertical": "vertical line of 60 mm at 0.25 Hz",
}


def sensing_plates(results: Results) -> list[Plate]:
    """For each trajectory the paths of one run each, and boxes over all runs."""
    found = {one.experiment: one for one in results.sensing}
    return [_plate(results, name, found.get(name)) for name in SENSING]


def _plate(results: Results, name: str, trajectory: SensedTrajectory | None) -> Plate:
    absent = [law for law in SENSING_LAWS if first(results, name, law=law) is None]
    caption = (
        f"Task 4, {NAMES[name]}, P1. Left: one run with each choice of sensors. Right: RMSE of all runs over the "
        "largest of this trajectory; the figure above each box is the mean [mm]."
    )
    missing = " ".join(why_missing(results, name, law=law) for law in absent)
    if trajectory is None or not trajectory.laws:
        return Plate(caption, missing=missing)
    panels = (
        panel(f"{name}: paths", partial(_draw_paths, results, name), TALL),
        panel(f"{name}: normalised RMSE", partial(_draw_boxes, trajectory), TALL),
    )
    return Plate(caption, panels, missing=missing)


def _draw_paths(results: Results, name: str, figure: Figure) -> None:
    axes = figure.add_subplot()
    for law in SENSING_LAWS:
        run = first(results, name, law=law)
        if run is not None:
            in_plane(axes, run.trace.tip[after_approach(run)], LAWS[law], LAW_NAMES[law])
            reference = run.trace.p_ref[once(run)]
    if axes.lines:
        in_plane(axes, reference, REFERENCE, "reference")
    plane(axes)
    key(figure, axes, 3)


def _draw_boxes(trajectory: SensedTrajectory, figure: Figure) -> None:
    axes = figure.add_subplot()
    for i, law in enumerate(trajectory.laws):
        look = {"color": LAWS[law.law]["color"], "linewidth": 1.1}
        axes.boxplot([law.normalised], positions=[i], widths=0.5, whis=(0, 100), boxprops=look, medianprops=look)
        spots = np.full(len(law.normalised), float(i))
        axes.plot(spots, law.normalised, "o", markersize=3.0, markerfacecolor="none", color=look["color"])
        top = max(law.normalised)
        axes.annotate(f"{np.mean(law.rmse):.1f} mm", (i, top), (0, 4), textcoords="offset points", ha="center")
    axes.set_xticks(range(len(trajectory.laws)), [LAW_NAMES[law.law] for law in trajectory.laws])
    axes.set(ylim=(0.0, 1.15), ylabel="RMSE / largest")
    axes.grid(visible=False, axis="x")
