"""The four steps under four laws (paper, Fig. "temporal and task-space response to four step inputs")."""

from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from controller.research.experiments.paper_rows import STEP_LAWS
from controller.research.experiments.results import Finished, Results
from controller.research.report.figures.look import LAW_NAMES, LAWS, MM, REFERENCE, in_plane, key, over_time, plane
from controller.research.report.figures.plate import TALL, Panel, Plate, first, panel, why_missing
from controller.schema.parameters import DT

LEAD = 0.5
"""Time shown before the first step [s]."""
CORNER: Any = {
    "color": "black",
    "linestyle": "none",
    "marker": "x",
    "markersize": 6.0,
    "markeredgewidth": 1.6,
    "zorder": 5,
}


def step_plates(results: Results) -> list[Plate]:
    """Tip over time under all laws, and its paths under FF and FF+PI."""
    runs = {law: run for law in STEP_LAWS if (run := first(results, "step", law=law))}
    missing = " ".join(why_missing(results, "step", law=law) for law in STEP_LAWS if law not in runs)
    caption = (
        "Four steps of 3 s that draw a diamond, P1. Above: x and y over time under four laws. Below: paths under FF "
        "and FF+PI; a cross marks each commanded corner, top first and clockwise."
    )
    panels = (*over_time_panels(runs), *path_panels(runs)) if runs else ()
    return [Plate(caption, panels, missing=missing)]


def over_time_panels(runs: dict[str, Finished]) -> list[Panel]:
    """Both coordinates from just before the first step."""
    name = f"over time under {len(runs)} laws"
    return [panel(f"{'xy'[axis]} {name}", partial(_draw_over_time, runs, axis), (3.5, 2.9)) for axis in range(2)]


def path_panels(runs: dict[str, Finished]) -> list[Panel]:
    """Paths under FF and FF+PI."""
    laws = [law for law in ("ff", "ff+pi") if law in runs]
    return [
        panel(f"path under {LAW_NAMES[law]} with the commanded corners", partial(_draw_path, law, runs[law]), TALL)
        for law in laws
    ]


def _draw_over_time(runs: dict[str, Finished], axis: int, figure: Figure) -> None:
    axes = figure.add_subplot()
    for i, (law, run) in enumerate(runs.items()):
        t, shown = _since_first_step(run)
        if i == 0:
            over_time(axes, t[shown], run.trace.p_ref[shown, axis] * MM, REFERENCE, "reference")
        over_time(axes, t[shown], run.trace.tip[shown, axis] * MM, LAWS[law], LAW_NAMES[law])
    axes.set(xlabel="time since the first step [s]", ylabel=f"{'xy'[axis]} [mm]")
    key(figure, axes, 5)


def _draw_path(law: str, run: Finished, figure: Figure) -> None:
    axes = figure.add_subplot()
    _, shown = _since_first_step(run)
    in_plane(axes, run.trace.tip[shown], LAWS[law], LAW_NAMES[law])
    corners = run.reference.p[list(run.reference.steps)] * MM
    axes.plot(corners[:, 0], corners[:, 1], label="commanded", **CORNER)
    plane(axes)
    key(figure, axes)


def _since_first_step(run: Finished) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] since the first step, and which are shown."""
    t = run.trace.t - run.reference.start * DT
    return t, t >= -LEAD
