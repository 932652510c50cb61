"""The identification report: one HTML page with parameters, residuals and plots, nothing outside it, fit to print."""

import math
from collections.abc import Iterator, Sequence
from html import escape

from controller.identification.fit import Estimate, Fit, Misfit
from controller.identification.panel import svg

STYLE = """
@page { size: A4; margin: 14mm }
body { font: 10pt/1.4 "Liberation Sans", Arial, Helvetica, sans-serif; color: #1a1a1a; background: #fff;
  max-width: 182mm; margin: 8mm auto; padding: 0 4mm }
h1 { font-size: 16pt; margin: 0 }
h2 { font-size: 12pt; margin: 6mm 0 1mm; border-top: 1px solid #999; padding-top: 2mm }
p { margin: 1mm 0 } ul { margin: 1mm 0; padding-left: 5mm } .about { color: #555 }
h2 { break-after: avoid }
table { break-inside: avoid; border-collapse: collapse; margin: 2mm 0; font-size: 9pt;
  font-variant-numeric: tabular-nums }
th, td { text-align: left; padding: .6mm 6mm .6mm 0; border-bottom: 1px solid #ddd; vertical-align: top }
th { font-weight: 600; border-bottom-color: #999 } .number { text-align: right }
.plots { display: grid; grid-template-columns: 1fr 1fr; gap: 2mm } .plots svg { width: 100%; height: auto }
.plots figure { margin: 0; break-inside: avoid } text { font-family: inherit !important }
pre { font: 8.5pt/1.35 "Liberation Mono", monospace; background: #f6f6f6; padding: 2mm; white-space: pre-wrap;
  break-inside: avoid }
@media print { body { margin: 0; padding: 0; max-width: none } }
@media (max-width: 600px) { .plots { grid-template-columns: 1fr } .wide { overflow-x: auto } }
"""


def report_page(heading: str, about: str, fits: Sequence[Fit], toml: str) -> str:
    """The whole page: `heading`, a line `about` the data, a section for each of `fits`, and the actuator file."""
    body = "".join(_section(fit) for fit in fits)
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(heading)}</title>'
        f'<meta name="viewport" content="width=device-width, initial-scale=1"><style>{STYLE}</style></head><body>'
        f'<h1>{escape(heading)}</h1><p class="about">{escape(about)}</p>{body}'
        f"<h2>Actuator file</h2><pre>{escape(toml)}</pre></body></html>\n"
    )


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
    plots = "".join(f"<figure>{svg(plot)}</figure>" for plot in fit.plots)
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

    return _table(("parameter", "value", "95 % confidence", "unit", ""), [tuple(row(one)) for one in parameters])


def _misfits(misfits: Sequence[Misfit]) -> str:
    rows = [(escape(one.name), f"{one.rms:.3g}", escape(one.unit), str(one.samples)) for one in misfits]
    return _table(("residual", "rms", "unit", "values"), rows)


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Cells are HTML already; the second column holds the numbers."""
    if not rows:
        return ""

    def line(cells: Sequence[str], tag: str) -> str:
        opening = (f"<{tag} class=number>" if i == 1 else f"<{tag}>" for i in range(len(cells)))
        return "<tr>" + "".join(f"{open}{cell}</{tag}>" for open, cell in zip(opening, cells, strict=True)) + "</tr>"

    return f'<div class="wide"><table>{line(head, "th")}{"".join(line(row, "td") for row in rows)}</table></div>'
