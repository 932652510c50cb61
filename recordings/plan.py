"""The plan view of a recording. rerun's 2-D views point y downwards, so y is negated here and nowhere else."""

from collections.abc import Callable
from typing import Any

import numpy as np
import rerun as rr

from controller.parameters import Actuator
from recordings.signals import MEASURED, OBSERVER, PLAN_PERIOD, REFERENCE, SECOND, TWIN, rgba

Rows = np.ndarray[Any, np.dtype[np.void]]
Points = np.ndarray[Any, np.dtype[np.float32]]
TimesOf = Callable[[Rows], list[rr.TimeColumn]]

OBSERVER_BACKBONE, TWIN_BACKBONE = "/plan/observer", "/plan/twin"
LINES = {OBSERVER_BACKBONE: "backbone", TWIN_BACKBONE: "twin_backbone"}
POINTS = {"/plan/target": "target", "/plan/reference": "p_ref", "/plan/tip": "p_meas"}
GRID = 0.05
"""Distance of the grid lines [m]."""


def on_grid(tick: np.ndarray[Any, np.dtype[np.int64]]) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Which ticks belong to the plan view's 100 Hz."""
    return np.asarray(tick % PLAN_PERIOD == 0)


def flip(points: np.ndarray[Any, Any]) -> Points:
    """Plane frame (y up) to rerun's 2-D frame (y down), and back: (..., 2)."""
    return np.asarray(points * (1.0, -1.0), np.float32)


def write_static(stream: rr.RecordingStream, actuator: Actuator) -> None:
    """Colours, sizes and what does not move: grid and clamp."""
    _style_lines(stream, OBSERVER_BACKBONE, OBSERVER, 2.5)
    _style_lines(stream, TWIN_BACKBONE, TWIN, 1.5)
    _style_points(stream, "/plan/markers", MEASURED, 3.5)
    _style_points(stream, "/plan/target", SECOND, 3.0)
    _style_points(stream, "/plan/reference", REFERENCE, 2.5)
    _style_points(stream, "/plan/tip", MEASURED, 2.0)
    _write_grid(stream, actuator.length)
    half = actuator.width
    clamp = rr.LineStrips2D([[(0.0, -half), (0.0, half)]], colors=rgba([0xDDDDDD]), radii=rr.Radius.ui_points(3.0))
    stream.log("/plan/clamp", clamp, static=True)


def write(stream: rr.RecordingStream, times: TimesOf, rows: Rows) -> None:
    """Backbones and points of `rows`; what is not known (nan) is left out."""
    for path, field in LINES.items():
        known = rows[np.isfinite(rows[field]).all(axis=(1, 2))]
        if len(known):
            strips = [[line] for line in flip(known[field])]
            stream.send_columns(path, times(known), rr.LineStrips2D.columns(strips=strips))
    for path, field in POINTS.items():
        _send_points(stream, path, times(rows), flip(rows[field])[:, None, :])


def write_markers(stream: rr.RecordingStream, times: list[rr.TimeColumn], rows: Rows) -> None:
    """Markers that are seen, as points."""
    _send_points(stream, "/plan/markers", times, flip(rows["markers"]))


def _send_points(stream: rr.RecordingStream, path: str, times: list[rr.TimeColumn], points: Points) -> None:
    """`points` (rows, k, 2); those that are nan are left out."""
    seen = np.isfinite(points).all(axis=2)
    columns = rr.Points2D.columns(positions=points[seen])
    stream.send_columns(path, times, [*columns.partition(seen.sum(axis=1))])


def _style_lines(stream: rr.RecordingStream, path: str, color: int, radius: float) -> None:
    style = rr.LineStrips2D.from_fields(colors=rgba([color]), radii=rr.Radius.ui_points(radius))
    stream.log(path, style, static=True)


def _style_points(stream: rr.RecordingStream, path: str, color: int, radius: float) -> None:
    style = rr.Points2D.from_fields(colors=rgba([color]), radii=rr.Radius.ui_points(radius))
    stream.log(path, style, static=True)


def _write_grid(stream: rr.RecordingStream, length: float) -> None:
    """Faint lines every 50 mm over the reach, and their numbers in mm."""
    steps = np.arange(-np.ceil(length / GRID), np.ceil(length / GRID) + 1) * GRID
    end = steps[-1]
    lines = [[(x, -end), (x, end)] for x in steps] + [[(-end, y), (end, y)] for y in steps]
    grid = rr.LineStrips2D(lines, colors=rgba([0x3A3F47] * len(lines)), radii=rr.Radius.ui_points(0.5), draw_order=-10)
    stream.log("/plan/grid", grid, static=True)
    marks = steps[::2]
    labels = [f"x {x * 1e3:.0f}" for x in marks] + [f"y {y * 1e3:.0f}" for y in marks]
    at = flip(np.array([(x, -end) for x in marks] + [(-end, y) for y in marks]))
    numbers = rr.Points2D(
        at, labels=labels, show_labels=True, colors=rgba([0x8A9099] * len(at)), radii=rr.Radius.ui_points(0.5)
    )
    stream.log("/plan/numbers", numbers, static=True)
