"""The identification report: one HTML page with parameters, residuals and plots, nothing outside it, fit to print."""

import math
from collections.abc import Iterator, Sequence
from html import escape

from controller.research.identification.fit import Estimate, Fit, Misfit
from controller.research.identification.report.panel import panel
from controller.research.page.document import document, table


def report_page(heading: str, about: str, fits: Sequence[Fit], toml: str) -> str:
    """The whole page: `heading`, a line `about` the data, a section for each of `fits`, and the actuator file."""
    body = "".join(_section(fit) for fit in fits)
    about_data = f'<p class="about">{escape(about)}</p>'
    return document(heading, f"{about_data}{body}<h2>Actuator file</h2><pre>{escape(toml)}</pre>")


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


def _section(fit: Fit) -> str:
    plots = "".join(f"<figure>{panel(plot)}</figure>" for plot in fit.plots)
    notes = "".join(f"<li>{escape(note)}</li>" for note in fit.notes)
    return (
        f"<h2>{escape(fit.title)}</h2><p>{escape(fit.method)}</p>{_parameters(fit.parameters)}{_misfits(fit.misfits)}"
        + (f"<ul>{notes}</ul>" if notes else "")
        + (f'<div class="plots">{plots}</div>' if plots else "")
    )


def _parameters(parameters: Sequence[Estimate]) -> str:
    def row(one: Estimate) -> Iterator[str]:
        half = (one.high - one.low) / 2
        yield from (escape(one.name), number_text(one.value, half))
        yield f"{number_text(one.low, half)} .. {number_text(one.high, half)}" if half > 0 else "-"
        yield from (escape(one.unit), escape(one.note))

    return table(("parameter", "value", "95 % confidence", "unit", ""), [tuple(row(one)) for one in parameters])


def _misfits(misfits: Sequence[Misfit]) -> str:
    rows = [(escape(one.name), f"{one.rms:.3g}", escape(one.unit), str(one.samples)) for one in misfits]
    return table(("residual", "rms", "unit", "values"), rows)
