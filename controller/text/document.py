"""The page itself: style sheet, frame and tables. Whatever is not `Markup` is text, and is escaped."""

from collections.abc import Collection, Iterable, Sequence

from markupsafe import Markup

STYLE = Markup("""
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
""")
PAGE = Markup(
    '<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{heading}</title>'
    '<meta name="viewport" content="width=device-width, initial-scale=1">'
    "<style>{common}{style}</style></head><body><h1>{heading}</h1>{body}</body></html>\n"
)
NOTHING = Markup()


def document(heading: str, body: Markup, style: Markup = NOTHING) -> str:
    """The whole page around `body`; `style` is CSS beside the common sheet."""
    return str(PAGE.format(heading=heading, common=STYLE, style=style, body=body))


def joined(parts: Iterable[str]) -> Markup:
    """`parts`, one after another."""
    return NOTHING.join(parts)


def table(head: Sequence[str], rows: Sequence[Sequence[str]], numbers: Collection[int] = (1,)) -> Markup:
    """A table; the columns `numbers` hold numbers. Nothing without rows."""
    if not rows:
        return NOTHING

    def line(cells: Sequence[str], plain: Markup, number: Markup) -> Markup:
        inside = joined((number if i in numbers else plain).format(cell) for i, cell in enumerate(cells))
        return Markup("<tr>{}</tr>").format(inside)

    first = line(head, Markup("<th>{}</th>"), Markup("<th class=number>{}</th>"))
    rest = joined(line(row, Markup("<td>{}</td>"), Markup("<td class=number>{}</td>")) for row in rows)
    return Markup('<div class="wide"><table>{}{}</table></div>').format(first, rest)


def dense(inside: Markup) -> Markup:
    """`inside` in the small type of long tables."""
    return Markup('<div class="dense">{}</div>').format(inside)
