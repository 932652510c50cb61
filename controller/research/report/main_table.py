"""The main table: every number of the paper beside ours, and why a row misses its bar."""

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from controller.research.experiments.paper_rows import FIT, NONE
from controller.research.experiments.results import ResultRow, Results
from controller.research.page.document import table
from controller.research.report.fitted import Key, fits, spread_of
from controller.research.report.remarks import known_remarks, remark
from controller.research.report.verdict import FIT_BAR, JUDGED_KEYS, NEAR, Verdict, verdict
from controller.research.report.wording import metric_name, number, paper_text, run_name, with_spread
from controller.simulation.metrics import Window

WHY = (
    f"Held-out rows more than {100 * NEAR:.0f} % from the paper, fitted RMSE more than {100 * FIT_BAR:.0f} %, and why:"
)


def main_table(results: Results, fit: Mapping[str, Any]) -> str:
    """Rows for which the paper gives a number: judged, fitted, then the ISE of the fitted runs. HTML."""
    rows = sorted((row for row in results.rows if row.about.role != NONE), key=_rank)
    spread = spread_of(fit)
    head = ["run", "metric", "paper", "ours", "ratio", "role", "bar", Window.WHOLE.value, Window.AFTER_APPROACH.value]
    if spread:
        head.append(f"over {fits(fit)} near-equal fits")
    cells = [_cells(row, spread) for row in rows]
    return f'<div class="dense">{table(head, cells, (2, 3, 4, 7, 8, 9))}</div>{remarks(rows, known_remarks())}'


def remarks(rows: Sequence[ResultRow], known: Mapping[str, str]) -> str:
    """Every judged row that is not near and every fitted RMSE over its bar, with the reason; HTML, nothing for none."""
    items = [
        f"<li><b>{run_name(row.about)}, {metric_name(row.about)}</b>: {escape(why)}</li>"
        for row in rows
        if (why := remark(row, known))
    ]
    return f"<p>{WHY}</p><ul>{''.join(items)}</ul>" if items else ""


def _rank(row: ResultRow) -> int:
    return 0 if row.about.key in JUDGED_KEYS else 1 if row.about.role == FIT else 2


def _cells(row: ResultRow, spread: dict[Key, str]) -> list[str]:
    whole, after = windows(row)
    ratio = "-" if row.ratio is None else f"{row.ratio:.2f}"
    name, bar = run_name(row.about), mark(verdict(row))
    ours = f"<b>{with_spread(row.ours, row.ours_std)}</b>"
    cells = [name, metric_name(row.about), paper_text(row.about), ours, ratio, row.about.role, bar, whole, after]
    return cells + ([spread.get(row.about.key, "")] if spread else [])


def windows(row: ResultRow) -> tuple[str, str]:
    """Ours over the whole run and after the approach; the paper's window in bold."""
    own, other = f"<b>{number(row.ours)}</b>", number(row.ours_other_window)
    return (own, other) if row.window is Window.WHOLE else (other, own)


def mark(found: Verdict) -> str:
    """A sign, a word and a colour; HTML."""
    if found.met is None:
        return escape(found.word)
    sign, kind = ("&#10003;", "met") if found.met else ("&#10007;", "over")
    return f'<span class="{kind}">{sign}&nbsp;{escape(found.word)}</span>'
