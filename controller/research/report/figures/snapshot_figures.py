"""The body in four moments of a turn: the observer's chain over the twin's body."""

from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from controller.arrays import Array
from controller.research.experiments.results import Finished, Results
from controller.research.report.figures.look import MM, OBSERVER, REFERENCE, TIP, in_plane, plane
from controller.research.report.figures.plate import Panel, Plate, panel, plate_of
from controller.research.report.spans import last_cycles, once
from controller.schema.actuator import PRESETS

APART = 0.3
"""Between two snapshots [s]."""
JOINT: Any = {"color": "#0072B2", "linestyle": "none", "marker": "o", "markersize": 2.4, "zorder": 4}


def snapshot_plate(results: Results) -> Plate:
    """Four moments of the circle at 1 Hz."""
    caption = (
        f"Four moments of the 1 Hz circle, {APART:g} s apart, P1: the observer's chain (blue) over the twin's body "
        "(grey); the circle is dashed. The paper sets photographs beside the observer."
    )
    return plate_of(results, "circle_1hz", "P1", caption, _snapshots, columns=4)


def outline(backbone: Array, width: float) -> Array:
    """Outline (2 n, 2) of a body of `width` about its backbone (n, 2), in the same unit."""
    tangent = np.gradient(backbone, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    side = 0.5 * width * np.column_stack([-tangent[:, 1], tangent[:, 0]])
    return np.vstack([backbone + side, (backbone - side)[::-1]])


def _snapshots(run: Finished) -> tuple[Panel, ...]:
    begin = np.flatnonzero(last_cycles(run, 1.0))[0]
    times = run.trace.t[begin] + APART * np.arange(4)
    return tuple(panel(f"body at {t:.1f} s", partial(_draw_body, run, t), (2.0, 2.3)) for t in times)


def _draw_body(run: Finished, t: float, figure: Figure) -> None:
    axes, trace, width = figure.add_subplot(), run.trace, PRESETS[run.case.actuator].width
    i = int(np.argmin(np.abs(trace.t - t)))
    body = outline(trace.twin_backbone[i].astype(np.float64), width) * MM
    axes.fill(body[:, 0], body[:, 1], facecolor="#e4e4e4", edgecolor=TIP["color"], linewidth=0.8, zorder=1)
    chain = trace.backbone[i] * MM
    axes.plot(chain[:, 0], chain[:, 1], **OBSERVER)
    axes.plot(chain[::2, 0], chain[::2, 1], **JOINT)
    in_plane(axes, trace.p_ref[once(run)], {**REFERENCE, "linewidth": 0.9})
    plane(axes, f"{trace.t[i]:.1f} s", "box")
    seen = np.concatenate([trace.twin_backbone[last_cycles(run, 1.0)].reshape(-1, 2), trace.p_ref[once(run)]])
    (x, y), (X, Y) = (seen.min(axis=0) - 0.6 * width) * MM, (seen.max(axis=0) + 0.6 * width) * MM
    axes.set(xlim=(x, X), ylim=(y, Y))
