"""How near a row is to the paper, against the bar for its role."""

from dataclasses import dataclass
from statistics import median

from controller.research.experiments.paper_rows import FIT, JUDGED, SEEN
from controller.research.experiments.results import ResultRow

FIT_BAR, NEAR, FACTOR = 0.2, 0.3, 1.5
"""Fitted RMSE within this share of the paper; held-out rows within this share, or within this factor."""
REDUCTION_BAR = 15.0
"""Points by which a reduction of Task 4 may be off the paper's."""
COVERAGE_WANTED = (0.8, 0.97)
"""Share of the fit rows whose interval is to hold the paper's number; with more it is too wide."""
INSIDE_WANTED = 0.8
"""Share of the held-out rows whose interval is to hold the paper's number; NEAR bounds the median of |ratio - 1|."""
JUDGED_KEYS = frozenset(one.key for one in JUDGED)
EXPLAINED_KEYS = JUDGED_KEYS | {one.key for one in SEEN}
"""Predicted rows of which a reader wants to know why they are off."""


@dataclass(frozen=True)
class Verdict:
    """A word, and whether the bar is met; None where there is no bar."""

    word: str
    met: bool | None


def verdict(row: ResultRow) -> Verdict:
    """`row` against its bar. Fitted SSE and spreads have none: they are as near as it gets."""
    if row.ours is None:
        return Verdict("failed", False)
    if row.ratio is None:
        return _between(row)
    if row.about.metric == "reduction":
        return Verdict("within 15 points", True) if within_points(row) else Verdict("over 15 points", False)
    if row.about.role == FIT:
        if row.about.metric != "rmse":
            return Verdict("no bar", None)
        return Verdict(*(("within 20 %", True) if within(row, FIT_BAR) else ("over 20 %", False)))
    if within(row, NEAR):
        return Verdict("within 30 %", True)
    return Verdict("within 1.5", True) if within_factor(row) else Verdict("over 1.5", False)


def within(row: ResultRow, share: float) -> bool:
    """Whether ours is within `share` of the paper's number."""
    return row.ratio is not None and abs(row.ratio - 1.0) <= share


def within_points(row: ResultRow) -> bool:
    """Whether a reduction of ours is within REDUCTION_BAR of the paper's."""
    ours, paper = row.ours, row.about.paper
    return ours is not None and paper is not None and abs(ours - paper) <= REDUCTION_BAR


def within_factor(row: ResultRow) -> bool:
    """Whether ours is within FACTOR of the paper's number, either way."""
    return row.ratio is not None and 1.0 / FACTOR <= row.ratio <= FACTOR


def judged(rows: tuple[ResultRow, ...]) -> list[ResultRow]:
    """The held-out rows by which the reproduction is judged, failed ones included."""
    return [row for row in rows if row.about.key in JUDGED_KEYS]


def consulted(rows: tuple[ResultRow, ...]) -> list[ResultRow]:
    """The rows that are predicted as well, but were looked at, without those that are no news."""
    return [row for row in rows if row.about.key in EXPLAINED_KEYS - JUDGED_KEYS]


def median_off(rows: list[ResultRow]) -> float | None:
    """Median of |ratio - 1|; None where no row has a ratio."""
    off = [abs(row.ratio - 1.0) for row in rows if row.ratio is not None]
    return median(off) if off else None


def _between(row: ResultRow) -> Verdict:
    """Against the paper's bounds, where it gives no one number."""
    low, high = row.about.paper_low, row.about.paper_high
    if row.ours is None or (low is None and high is None):
        return Verdict("", None)
    inside = (low is None or low <= row.ours) and (high is None or row.ours <= high)
    return Verdict("inside" if inside else "outside", inside)
