"""What the reader wants to know first: the bars and whether they are met, then where the numbers come from."""

import os
import platform
from collections.abc import Mapping
from datetime import UTC, datetime
from html import escape
from itertools import pairwise
from pathlib import Path
from typing import Any

from controller.experiments.paper_rows import DIGITS, FEEDBACK_SHARE, FIT, JUDGED
from controller.experiments.report.fitted import provenance
from controller.experiments.report.verdict import FIT_BAR, NEAR, NEAR_WANTED, judged, within, within_factor
from controller.experiments.report.wording import number
from controller.experiments.results import ResultRow, Results
from controller.page.document import table

OBSERVER_BAR = 2.2
"""Largest RMS distance of the observer's tip from the twin's in Tasks 1 and 2 of P1 [mm]."""
OBSERVED = (*DIGITS, "vu", "vertical_0.25hz", "vertical_1hz", "horizontal_0.25hz", "horizontal_1hz", "circle_1hz")


def headline(results: Results, fit: Mapping[str, Any]) -> str:
    """Bars as a list, facts as a table; HTML."""
    bars = (held_out(results), fitted(results), observer(results), sensing(results), share(results), failures(results))
    items = "".join(f"<li>{escape(bar)}</li>" for bar in bars if bar)
    facts = [*provenance(fit), *circumstances(results)]
    return f"<ul>{items}</ul>" + table(("", ""), [(escape(name), escape(value)) for name, value in facts], ())


def held_out(results: Results) -> str:
    """How many of the judged rows are near the paper."""
    rows = judged(results.rows)
    near, far = sum(within(row, NEAR) for row in rows), sum(within_factor(row) for row in rows)
    return (
        f"Held-out rows: {near} of {len(JUDGED)} within 30 % of the paper (wanted: {NEAR_WANTED}), {far} of "
        f"{len(JUDGED)} within a factor 1.5 (wanted: all)."
    )


def fitted(results: Results) -> str:
    """How near the fitted rows are."""
    rows = [row for row in results.rows if row.about.role == FIT]
    errors = [row for row in rows if row.about.metric == "rmse"]
    rest = [row.ratio for row in rows if row.about.metric != "rmse" and row.ratio is not None]
    near = sum(within(row, FIT_BAR) for row in errors)
    text = f"Rows that the twin was fitted to: {near} of {len(errors)} RMSE within 20 % of the paper"
    return text + (f"; SSE {min(rest):.2f} to {max(rest):.2f} times the paper's." if rest else ".")


def observer(results: Results) -> str:
    """The worst observer of Tasks 1 and 2."""
    rows = [row for row in results.rows if _observed(row) and row.ours is not None]
    if not rows:
        return ""
    worst = max(rows, key=lambda row: row.ours or 0.0)
    met = sum((row.ours or 0.0) <= OBSERVER_BAR for row in rows)
    return (
        f"Observer's tip against the twin's, P1, Tasks 1 and 2: {met} of {len(rows)} runs within {OBSERVER_BAR} mm "
        f"rms; at most {number(worst.ours)} mm ({worst.about.experiment}, {worst.window})."
    )


def sensing(results: Results) -> str:
    """Whether Task 4 has the paper's order."""
    ordered = sum(one.ordered for one in results.sensing)
    return f"Task 4: the paper's order of sensors on {ordered} of {len(results.sensing)} trajectories."


def share(results: Results) -> str:
    """Whether the feedback's share rises with frequency."""
    points = [(one.frequency, one.share) for one in results.sweep if one.share is not None]
    if len(points) < 2:
        return ""
    failed = ", ".join(f"{one.frequency:g} Hz" for one in results.sweep if one.share is None)
    rising = all(b[1] > a[1] for a, b in pairwise(points))
    (low, first), (high, last) = points[0], points[-1]
    course = "rises at every frequency" if rising else "does not rise at every frequency"
    paper = ", ".join(f"{100 * value:.0f} % at {f:g} Hz" for f, value in FEEDBACK_SHARE.items())
    return (
        f"Share of the feedback {course}: {100 * first:.0f} % at {low:g} Hz, {100 * last:.0f} % at {high:g} Hz "
        f"(paper: {paper})" + (f"; failed: {failed}." if failed else ".")
    )


def failures(results: Results) -> str:
    """How many runs did not come to their end."""
    count = len(results.failures)
    return f"{count} of {results.runs} runs failed; see below." if count else "No run failed."


def failed_runs(results: Results) -> str:
    """All runs that did not come to their end, with their sentences; HTML."""
    rows = [
        (escape(f"{case.reference}, {case.actuator}, {case.law}"), str(case.seed), escape(one.sentence))
        for one in results.failures
        for case in (one.case,)
    ]
    return table(("run", "seed", "why"), rows)


def circumstances(results: Results) -> list[tuple[str, str]]:
    """When, where and with which seeds."""
    cores = os.cpu_count() or 1
    return [
        ("run", datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC") + (", quick: each once" if results.quick else "")),
        ("machine", f"{processor()}, {cores} cores; Python {platform.python_version()}, {platform.system()}"),
        (
            "time",
            f"{results.seconds:.0f} s with {results.workers} process{'es' * (results.workers > 1)}, this page excluded",
        ),
        ("seeds", ", ".join(map(str, results.seeds))),
    ]


def processor() -> str:
    """Name of the processor, as far as the system tells."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    named = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return next(iter(named), platform.processor() or platform.machine())


def _observed(row: ResultRow) -> bool:
    about = row.about
    return about.metric == "observer_rmse" and about.actuator == "P1" and about.experiment in OBSERVED
