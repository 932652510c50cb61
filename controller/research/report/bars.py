"""The bars of a reproduction as sentences: each says what is wanted and what was found."""

from itertools import pairwise

from controller.research.experiments.paper_rows import DIGITS, FEEDBACK_SHARE, FIT, JUDGED
from controller.research.experiments.results import ResultRow, Results
from controller.research.report.verdict import FACTOR, FIT_BAR, NEAR, NEAR_WANTED, judged, within, within_factor
from controller.research.report.wording import number

OBSERVER_BAR = 2.2
"""Largest RMS distance of the observer's tip from the twin's in Tasks 1 and 2 of P1 [mm]."""
OBSERVED = (*DIGITS, "vu", "vertical_0.25hz", "vertical_1hz", "horizontal_0.25hz", "horizontal_1hz", "circle_1hz")


def bars(results: Results) -> list[str]:
    """All of them; those of which nothing was run are left out."""
    found = (held_out(results), fitted(results), observer(results), sensing(results), share(results))
    return [sentence for sentence in found if sentence]


def held_out(results: Results) -> str:
    """How many of the judged rows are near the paper."""
    rows = judged(results.rows)
    near, far = sum(within(row, NEAR) for row in rows), sum(within_factor(row) for row in rows)
    return (
        f"Held-out rows: {near} of {len(JUDGED)} within {100 * NEAR:.0f} % of the paper (wanted: {NEAR_WANTED}), {far} "
        f"of {len(JUDGED)} within a factor {FACTOR:g} (wanted: all)."
    )


def fitted(results: Results) -> str:
    """How near the fitted rows are."""
    rows = [row for row in results.rows if row.about.role == FIT]
    errors = [row for row in rows if row.about.metric == "rmse"]
    rest = [row.ratio for row in rows if row.about.metric != "rmse" and row.ratio is not None]
    near = sum(within(row, FIT_BAR) for row in errors)
    text = (
        f"Rows that the twin was fitted to: {near} of {len(errors)} RMSE within {100 * FIT_BAR:.0f} % of the paper "
        "(wanted: all)"
    )
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
    if not results.sensing:
        return ""
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


def _observed(row: ResultRow) -> bool:
    about = row.about
    return about.metric == "observer_rmse" and about.actuator == "P1" and about.experiment in OBSERVED
