"""The main table: every number of the paper beside ours, and why a row misses its bar."""

from collections.abc import Mapping, Sequence
from typing import Any

from markupsafe import Markup

from controller.research.experiments.paper_rows import CONSULTED, FIT, HELD_OUT, NONE
from controller.research.experiments.results import ResultRow, Results
from controller.research.report.fitted import fits
from controller.research.report.remarks import known_remarks, remark
from controller.research.report.verdict import FIT_BAR, NEAR, Verdict, verdict
from controller.research.report.wording import bold, metric_name, number, paper_text, run_name, with_spread
from controller.simulation.metrics import Window
from controller.text.document import dense, joined, table

WHY = (
    f"Predicted rows more than {100 * NEAR:.0f} % from the paper, fitted RMSE more than {100 * FIT_BAR:.0f} %, and why:"
)


def main_table(results: Results, fit: Mapping[str, Any]) -> Markup:
    """Rows for which the paper gives a number: held out, consulted, fitted."""
    rows = sorted((row for row in results.rows if row.about.role != NONE), key=_rank)
    spread = any(row.interval is not None for row in rows)
    head = ["run", "metric", "paper", "ours", "ratio", "role", "bar", Window.WHOLE.value, Window.AFTER_APPROACH.value]
    if spread:
        head.append(f"interval of {fits(fit)} near-equal fits")
    cells = [_cells(row, spread) for row in rows]
    return dense(table(head, cells, (2, 3, 4, 7, 8, 9))) + remarks(rows, known_remarks())


def remarks(rows: Sequence[ResultRow], known: Mapping[str, str]) -> Markup:
    """Every predicted row that is not near and every fitted RMSE over its bar, with the reason; nothing for none."""
    item = Markup("<li><b>{}, {}</b>: {}</li>")
    items = joined(
        item.format(run_name(row.about), metric_name(row.about.metric, row.about.unit), why)
        for row in rows
        if (why := remark(row, known))
    )
    return Markup("<p>{}</p><ul>{}</ul>").format(WHY, items) if items else items


def _rank(row: ResultRow) -> int:
    return (HELD_OUT, CONSULTED, FIT).index(row.about.role)


def _cells(row: ResultRow, spread: bool) -> list[str]:
    whole, after = windows(row)
    ratio = "-" if row.ratio is None else f"{row.ratio:.2f}"
    about, bar = row.about, mark(verdict(row))
    named = run_name(about), metric_name(about.metric, about.unit), paper_text(about)
    cells = [*named, bold(with_spread(row.ours, row.ours_std)), ratio, about.role, bar, whole, after]
    return cells + ([interval_text(row)] if spread else [])


def interval_text(row: ResultRow) -> str:
    """The interval, and whether the paper's number is in it."""
    if row.interval is None:
        return ""
    low, high = row.interval
    return Markup("{} .. {} {}").format(number(low), number(high), mark(Verdict("", row.inside)))


def windows(row: ResultRow) -> tuple[str, str]:
    """Ours over the whole run and after the approach; the paper's window in bold."""
    own, other = bold(number(row.ours)), number(row.ours_other_window)
    return (own, other) if row.window is Window.WHOLE else (other, own)


def mark(found: Verdict) -> str:
    """A sign, a word and a colour."""
    if found.met is None:
        return found.word
    sign, kind = ("✓", "met") if found.met else ("✗", "over")
    return Markup('<span class="{}">{}&nbsp;{}</span>').format(kind, sign, found.word)
