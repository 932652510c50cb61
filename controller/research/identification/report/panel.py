"""One panel of the identification report as SVG text."""

from itertools import cycle
from typing import Any

from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator

from controller.research.drawing import svg
from controller.research.identification.fit import Plot

MARKS = ("#123f70", "#8f3a0c", "#1d5634", "#5f2563", "#3d3d3d", "#6f5813")
LINES = ("#5c9be0", "#f0935c", "#66bd8a", "#c07fc6", "#a5a5a5", "#d6b85a")
"""Colours of measured points and, a lighter shade of the same, of the model's curve beside them."""

MANY = 1500
"""Points of one series beyond which they are drawn as a picture: a mark in SVG takes 100 bytes."""

POINTS: Any = {
    "linestyle": "none",
    "marker": "o",
    "markersize": 2.6,
    "markerfacecolor": "none",
    "markeredgewidth": 0.7,
    "zorder": 3,
}
LINE: Any = {"linewidth": 1.1}


def panel(plot: Plot) -> Markup:
    """`plot` as an <svg> element."""
    return svg(lambda figure: _draw(figure.add_subplot(), plot))


def _draw(axes: Axes, plot: Plot) -> None:
    """Measured points and the curve of the model beside them come in the same order, and so share a hue."""
    marks, lines = cycle(MARKS), cycle(LINES)
    for series in plot.series:
        colour, look = (next(marks), POINTS) if series.style == "points" else (next(lines), LINE)
        axes.plot(series.x, series.y, color=colour, label=series.label, rasterized=series.x.size > MANY, **look)
    axes.set(title=plot.title, xlabel=plot.x_label, ylabel=plot.y_label)
    if plot.log_x:
        axes.set_xscale("log")
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.xaxis.set_major_formatter("{x:g}")
        axes.xaxis.set_minor_formatter("")
    if plot.equal_axes:
        axes.set_aspect("equal", adjustable="datalim")
    if any(series.label for series in plot.series):
        axes.legend()
