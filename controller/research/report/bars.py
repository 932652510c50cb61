"""The bars of a reproduction as sentences: each says what is wanted and what was found."""

from itertools import pairwise

from controller.research.experiments.paper_rows import DIGITS, FEEDBACK_SHARE, FIT
from controller.research.experiments.results import ResultRow, Results
from controller.research.report.verdict import (
    COVERAGE_WANTED,
    FACTOR,
    FIT_BAR,
    INSIDE_WANTED,
    NEAR,
    REDUCTION_BAR,
    consulted,
    judged,
    median_off,
    within,
    within_factor,
    within_points,
)
from controller.research.report.wording import number

OBSERVER_BAR = 2.2
"""Largest RMS distance of the observer's tip from the twin's in Tasks 1 and 2 of P1 [mm]."""
OBSERVED = (*DIGITS, "vu", "vertical_0.25hz", "vertical_1hz", "horizontal_0.25hz", "horizontal_1hz", "circle_1hz")


def bars(results: Results) -> list[str]:
    """All of them; of what nothing was run is said or left out."""
    found = (
        fitted(results),
        covered(results),
        held_out(results),
        looked_at(results),
        observer(results),
        sensing(results),
        share(results),
    )
    return [sentence for sentence in found if sentence]


def held_out(results: Results) -> str:
    """How many of the judged rows have the paper's number in their interval, and how near they are."""
    rows = judged(results.rows)
    wanted = f" (wanted: {100 * INSIDE_WANTED:.0f} %)", f" (wanted: at most {NEAR:g})"
    return near_the_paper("Held-out rows", rows, wanted)


def looked_at(results: Results) -> str:
    """The same of the consulted rows, for which nothing is wanted."""
    rows = consulted(results.rows)
    return near_the_paper("Consulted rows", rows, ("", ""))


def near_the_paper(name: str, rows: list[ResultRow], wanted: tuple[str, str]) -> str:
    """Intervals, where there are any, and ratios of `rows` in one sentence."""
    if not rows:
        return f"{name}: none was run."
    known = [row.inside for row in rows if row.inside is not None]
    text = f"{sum(known)} of {len(rows)} have the paper in their interval{wanted[0]}, " if known else ""
    off, near = median_off(rows), sum(within_factor(row) for row in rows)
    median = "none has a number" if off is None else f"the median of |ratio - 1| is {off:.2f}{wanted[1]}"
    return f"{name}: {text}{median}, {near} of {len(rows)} are within a factor {FACTOR:g}."


def fitted(results: Results) -> str:
    """How near the fitted rows are."""
    rows = [row for row in results.rows if row.about.role == FIT]
    errors = [row for row in rows if row.about.metric == "rmse"]
    rest = [row.ratio for row in rows if row.about.metric == "sse" and row.ratio is not None]
    near = sum(within(row, FIT_BAR) for row in errors)
    text = (
        f"Rows that the twin was fitted to: {near} of {len(errors)} RMSE within {100 * FIT_BAR:.0f} % of the paper "
        "(wanted: all)"
    )
    return text + (f"; SSE {min(rest):.2f} to {max(rest):.2f} times the paper's." if rest else ".")


def covered(results: Results) -> str:
    """How many of the fitted rows have the paper's number in their interval."""
    known = [row.inside for row in results.rows if row.about.role == FIT and row.inside is not None]
    if not known:
        return ""
    low, high = (f"{100 * share:.0f}" for share in COVERAGE_WANTED)
    share = f"{sum(known)} of {len(known)} = {100 * sum(known) / len(known):.0f} %"
    return f"Fitted rows with the paper in their interval: {share} (wanted: {low} to {high} %)."


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
    """Whether Task 4 has the paper's order and its reductions."""
    ordered = sum(one.ordered for one in results.sensing)
    if not results.sensing:
        return ""
    text = f"Task 4: the paper's order of sensors on {ordered} of {len(results.sensing)} trajectories"
    rows = [row for row in results.rows if row.about.metric == "reduction"]
    near = f", {sum(map(within_points, rows))} of {len(rows)} reductions within {REDUCTION_BAR:g} points"
    return text + (f"{near} of the paper's (wanted: all)." if rows else ".")


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
