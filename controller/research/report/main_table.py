"""The main table: every number of the paper beside ours, and why a row misses its bar."""

from collections.abc import Mapping, Sequence
from typing import Any

from markupsafe import Markup

from controller.research.experiments.paper_rows import FIT, NONE
from controller.research.experiments.results import ResultRow, Results
from controller.research.page.document import dense, joined, table
from controller.research.report.fitted import Key, fits, spread_of
from controller.research.report.remarks import known_remarks, remark
from controller.research.report.verdict import FIT_BAR, JUDGED_KEYS, NEAR, Verdict, verdict
from controller.research.report.wording import bold, metric_name, number, paper_text, run_name, with_spread
from controller.simulation.metrics import Window

WHY = (
    f"Held-out rows more than {100 * NEAR:.0f} % from the paper, fitted RMSE more than {100 * FIT_BAR:.0f} %, and why:"
)


def main_table(results: Results, fit: Mapping[str, Any]) -> Markup:
    """Rows for which the paper gives a number: judged, fitted, then the ISE of the fitted runs."""
    rows = sorted((row for row in results.rows if row.about.role != NONE), key=_rank)
    spread = spread_of(fit)
    head = ["run", "metric", "paper", "ours", "ratio", "role", "bar", Window.WHOLE.value, Window.AFTER_APPROACH.value]
    if spread:
        head.append(f"over {fits(fit)} near-equal fits")
    cells = [_cells(row, spread) for row in rows]
    return dense(table(head, cells, (2, 3, 4, 7, 8, 9))) + remarks(rows, known_remarks())


def remarks(rows: Sequence[ResultRow], known: Mapping[str, str]) -> Markup:
    """Every judged row that is not near and every fitted RMSE over its bar, with the reason; nothing for none."""
    item = Markup("<li><b>{}, {}</b>: {}</li>")
    items = joined(
        item.format(run_name(row.about), metric_name(row.about.metric, row.about.unit), why)
        for row in rows
        if (why := remark(row, known))
    )
    return Markup("<p>{}</p><ul>{}</ul>").format(WHY, items) if items else items


def _rank(row: ResultRow) -> int:
    return 0 if row.about.key in JUDGED_KEYS else 1 if row.about.role == FIT else 2


def _cells(row: ResultRow, spread: dict[Key, str]) -> list[str]:
    whole, after = windows(row)
    ratio = "-" if row.ratio is None else f"{row.ratio:.2f}"
    about, bar = row.about, mark(verdict(row))
    named = run_name(about), metric_name(about.metric, about.unit), paper_text(about)
    cells = [*named, bold(with_spread(row.ours, row.ours_std)), ratio, about.role, bar, whole, after]
    return cells + ([spread.get(row.about.key, "")] if spread else [])


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
