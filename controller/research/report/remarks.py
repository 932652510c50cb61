"""Why rows are further from the paper than they are wanted to be, as far as a reason is known."""

import tomllib
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

from controller.research.experiments.paper_rows import FIT
from controller.research.experiments.results import ResultRow
from controller.research.report.verdict import EXPLAINED_KEYS, FIT_BAR, NEAR, within

REMARKS_FILE = Path(__file__).with_name("remarks.toml")
UNKNOWN = "no reason known"


@cache
def known_remarks(path: Path = REMARKS_FILE) -> Mapping[str, str]:
    """Remarks by "experiment actuator law metric"."""
    found: dict[str, str] = tomllib.loads(path.read_text(encoding="utf-8"))
    return found


def needs_remark(row: ResultRow) -> bool:
    """Whether `row` is a predicted one that is not within NEAR, or a fitted RMSE that is not within FIT_BAR."""
    if row.about.key in EXPLAINED_KEYS:
        return not within(row, NEAR)
    return row.about.role == FIT and row.about.metric == "rmse" and not within(row, FIT_BAR)


def remark(row: ResultRow, known: Mapping[str, str]) -> str:
    """Why `row` is where it is; UNKNOWN if no one knows, nothing where nothing needs to be said."""
    if not needs_remark(row):
        return ""
    return row.failed or known.get(name(row), UNKNOWN)


def outdated(rows: Sequence[ResultRow], known: Mapping[str, str]) -> list[str]:
    """Rows that have a remark and no longer need it."""
    return [name(row) for row in rows if name(row) in known and not needs_remark(row)]


def name(row: ResultRow) -> str:
    """Key of a row's remark."""
    return " ".join(row.about.key)
