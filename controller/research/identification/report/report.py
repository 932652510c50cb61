"""The identification report: one HTML page with parameters, residuals and plots, nothing outside it, fit to print."""

import math
from collections.abc import Sequence
from itertools import cycle
from typing import Any

from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator

from controller.research.drawing import svg
from controller.research.identification.fit import Estimate, Fit, Misfit, Plot
from controller.text.document import document, joined, table

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


def report_page(heading: str, about: str, fits: Sequence[Fit], toml: str) -> str:
    """The whole page: `heading`, a line `about` the data, a section for each of `fits`, and the actuator file."""
    body = Markup('<p class="about">{}</p>{}<h2>Actuator file</h2><pre>{}</pre>')
    return document(heading, body.format(about, joined(map(_section, fits)), toml))


def number_text(value: float, half: float) -> str:
    """`value` to two digits of its uncertainty `half`; four digits where that says nothing."""
    if not math.isfinite(value):
        return "-"
    if not (math.isfinite(half) and half > 0):
        return f"{value:.4g}"
    digits = 1 - math.floor(math.log10(half))
    if 1e-3 <= abs(value) < 1e5 or value == 0:
        return f"{value:.{max(0, digits)}f}"
    return f"{value:.{max(0, digits + math.floor(math.log10(abs(value))))}e}"


def _section(fit: Fit) -> Markup:
    plots = joined(Markup("<figure>{}</figure>").format(panel(plot)) for plot in fit.plots)
    notes = joined(Markup("<li>{}</li>").format(note) for note in fit.notes)
    parts = (
        Markup("<h2>{}</h2><p>{}</p>").format(fit.title, fit.method),
        _parameters(fit.parameters),
        _misfits(fit.misfits),
        Markup("<ul>{}</ul>").format(notes) if notes else notes,
        Markup('<div class="plots">{}</div>').format(plots) if plots else plots,
    )
    return joined(parts)


def _parameters(parameters: Sequence[Estimate]) -> Markup:
    def row(one: Estimate) -> tuple[str, ...]:
        half = (one.high - one.low) / 2
        interval = f"{number_text(one.low, half)} .. {number_text(one.high, half)}" if half > 0 else "-"
        return one.name, number_text(one.value, half), interval, one.unit, one.note

    return table(("parameter", "value", "95 % confidence", "unit", ""), [row(one) for one in parameters])


def _misfits(misfits: Sequence[Misfit]) -> Markup:
    rows = [(one.name, f"{one.rms:.3g}", one.unit, str(one.samples)) for one in misfits]
    return table(("residual", "rms", "unit", "values"), rows)
