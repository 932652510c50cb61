"""The plan view of a recording, as rerun draws it."""

from collections.abc import Callable
from typing import Any

import numpy as np
import rerun as rr

from controller.arrays import Array32, Mask, Rows, Words
from controller.schema.actuator import Actuator
from controller.schema.palette import MEASURED, OBSERVER, REFERENCE, TWIN
from recordings.format.signals import BACKBONES, OBSERVER_BACKBONE, PLAN_PERIOD, TARGET, TWIN_BACKBONE, flip, rgba

TimesOf = Callable[[Rows], list[rr.TimeColumn]]

POINTS = {"/plan/target": "target", "/plan/reference": "p_ref", "/plan/tip": "p_meas"}
GRID = 0.05
"""Distance of the grid lines [m]."""
ON_DARK, ON_LIGHT = (0x2C3138, 0x59616B, 0xDDDDDD), (0xE3E6EA, 0x9AA2AB, 0x3C434A)
"""Colours of grid, axes with their numbers, and clamp."""


def on_grid(tick: Words) -> Mask:
    """Which ticks belong to the plan view's 100 Hz."""
    return np.asarray(tick % PLAN_PERIOD == 0)


def write_static(stream: rr.RecordingStream, actuator: Actuator) -> None:
    """Colours, sizes, order of drawing, and what does not move."""
    _style(stream, rr.LineStrips2D, TWIN_BACKBONE, (TWIN, 3.0, 10.0))
    _style(stream, rr.LineStrips2D, OBSERVER_BACKBONE, (OBSERVER, 2.0, 20.0))
    _style(stream, rr.Points2D, "/plan/markers", (MEASURED, 3.5, 50.0))
    _style(stream, rr.Points2D, "/plan/target", (TARGET, 6.0, 30.0))
    _style(stream, rr.Points2D, "/plan/reference", (REFERENCE, 2.5, 40.0))
    _style(stream, rr.Points2D, "/plan/tip", (MEASURED, 2.0, 41.0))
    write_scenery(stream, actuator, ON_DARK)


def write_scenery(stream: rr.RecordingStream, actuator: Actuator, colors: tuple[int, int, int]) -> None:
    """What does not move, grid and clamp, in `colors`."""
    grid, axes, clamp = colors
    _write_grid(stream, actuator.length, grid, axes)
    line = [[(0.0, -actuator.width), (0.0, actuator.width)]]
    stream.log("/plan/clamp", _thin(line, clamp, 2.5), static=True)


def write(stream: rr.RecordingStream, times: TimesOf, rows: Rows) -> None:
    """Backbones and points of `rows`; what is not known (nan) is left out."""
    for path, field in BACKBONES.items():
        known = rows[np.isfinite(rows[field]).all(axis=(1, 2))]
        if len(known):
            strips = [[line] for line in flip(known[field])]
            stream.send_columns(path, times(known), rr.LineStrips2D.columns(strips=strips))
    for path, field in POINTS.items():
        _send_points(stream, path, times(rows), flip(rows[field])[:, None, :])


def write_markers(stream: rr.RecordingStream, times: list[rr.TimeColumn], rows: Rows) -> None:
    """Markers that are seen, as points."""
    _send_points(stream, "/plan/markers", times, flip(rows["markers"]))


def _send_points(stream: rr.RecordingStream, path: str, times: list[rr.TimeColumn], points: Array32) -> None:
    """`points` (rows, k, 2); those that are nan are left out."""
    seen = np.isfinite(points).all(axis=2)
    columns = rr.Points2D.columns(positions=points[seen])
    stream.send_columns(path, times, [*columns.partition(seen.sum(axis=1))])


def _style(stream: rr.RecordingStream, kind: Any, path: str, look: tuple[int, float, float]) -> None:
    """Colour, radius [pixels] and drawing order of all that comes at `path`."""
    color, radius, order = look
    style = kind.from_fields(colors=rgba([color]), radii=rr.Radius.ui_points(radius), draw_order=order)
    stream.log(path, style, static=True)


def _write_grid(stream: rr.RecordingStream, length: float, grid: int, axes: int) -> None:
    """Faint lines every 50 mm over the reach, with their numbers in mm along the axes."""
    steps = np.arange(-np.ceil(length / GRID), np.ceil(length / GRID) + 1) * GRID
    end = steps[-1]
    lines = [[(x, -end), (x, end)] for x in steps] + [[(-end, y), (end, y)] for y in steps]
    stream.log("/plan/grid", _thin(lines, grid, 0.5), static=True)
    stream.log("/plan/axes", _thin([[(0, -end), (0, end)], [(-end, 0), (end, 0)]], axes, 0.75), static=True)
    marks = [step for step in steps if abs(step) <= length and round(step / GRID) % 2 == 0]
    across = [x for x in marks if x >= -0.5 * length]
    at = flip(np.array([(x, -0.95 * length) for x in across] + [(-0.5 * length, y) for y in marks]))
    labels = [f"{value * 1e3:.0f}" for value in across + marks]
    points = rr.Points2D(
        at, labels=labels, show_labels=True, colors=rgba([axes] * len(at)), radii=rr.Radius.ui_points(1.5)
    )
    stream.log("/plan/axes/mm", points, static=True)


def _thin(lines: Any, color: int, radius: float) -> rr.LineStrips2D:
    return rr.LineStrips2D(lines, colors=rgba([color] * len(lines)), radii=rr.Radius.ui_points(radius), draw_order=-10)
