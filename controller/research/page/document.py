"""The page itself: style sheet, frame and tables, as HTML text."""

from collections.abc import Sequence
from html import escape

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


def document(heading: str, body: str, style: str = "") -> str:
    """The whole page around `body` (HTML); `style` is CSS beside the common sheet."""
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(heading)}</title>'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<style>{STYLE}{style}</style></head><body><h1>{escape(heading)}</h1>{body}</body></html>\n"
    )


def table(head: Sequence[str], rows: Sequence[Sequence[str]], numbers: Sequence[int] = (1,)) -> str:
    """A table of cells that are HTML already; the columns `numbers` hold numbers. Nothing without rows."""
    if not rows:
        return ""

    def line(cells: Sequence[str], tag: str) -> str:
        opening = (f"<{tag} class=number>" if i in numbers else f"<{tag}>" for i in range(len(cells)))
        return "<tr>" + "".join(f"{open}{cell}</{tag}>" for open, cell in zip(opening, cells, strict=True)) + "</tr>"

    return f'<div class="wide"><table>{line(head, "th")}{"".join(line(row, "td") for row in rows)}</table></div>'
