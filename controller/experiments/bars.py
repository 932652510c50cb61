"""How near a row has to be to the paper's number, and how near ours are."""

from collections.abc import Iterable
from enum import StrEnum

from controller.experiments.paper_rows import FIT, HELD_OUT, JUDGED
from controller.experiments.results import ResultRow

FIT_WITHIN = 0.20
"""Fitted RMSE: share of the paper's number."""
NEAR_WITHIN = 0.30
"""At least NEAR_COUNT of the judged held-out rows are within this share of the paper's number ..."""
NEAR_COUNT = 7
FACTOR = 1.5
"""... and each of them within this factor."""


class Mark(StrEnum):
    """What a row's ratio to the paper says."""

    OK = "ok"
    """A fitted row within FIT_WITHIN, a held-out one within NEAR_WITHIN."""
    NEAR = "near"
    """A held-out row only within FACTOR."""
    OVER = "over"
    """Beyond its bar, on either side."""
    FAILED = "failed"
    """The run did not come to its end."""
    NONE = ""
    """The paper gives no one number."""


def mark(row: ResultRow) -> Mark:
    """The row against its bar."""
    if row.failed:
        return Mark.FAILED
    if row.ratio is None:
        return Mark.NONE
    within = FIT_WITHIN if row.about.role == FIT else NEAR_WITHIN
    if abs(row.ratio - 1.0) <= within:
        return Mark.OK
    return Mark.NEAR if row.about.role == HELD_OUT and 1.0 / FACTOR <= row.ratio <= FACTOR else Mark.OVER


def fitted_rmse(rows: Iterable[ResultRow]) -> list[ResultRow]:
    """The fitted rows that have a bar; for the steady-state errors there is none."""
    return [row for row in rows if row.about.role == FIT and row.about.metric == "rmse"]


def judged(rows: Iterable[ResultRow]) -> list[ResultRow]:
    """The held-out rows by which a reproduction is judged, in the order of `paper_rows.JUDGED`."""
    by_key = {row.about.key: row for row in rows}
    return [by_key[paper.key] for paper in JUDGED if paper.key in by_key]
