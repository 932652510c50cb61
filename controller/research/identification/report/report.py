"""The identification report: one HTML page with parameters, residuals and plots, nothing outside it, fit to print."""

import math
from collections.abc import Sequence

from markupsafe import Markup

from controller.research.identification.fit import Estimate, Fit, Misfit
from controller.research.identification.report.panel import panel
from controller.text.document import document, joined, table


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
