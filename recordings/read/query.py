"""Search and order in the list of recordings."""

from collections.abc import Iterable
from typing import Any

from controller.errors import ParameterError
from recordings.format.messages import Metrics, Recording

COLUMNS: tuple[str, ...] = (
    "started",
    "name",
    "id",
    "seconds",
    "rows",
    "gaps",
    "bytes",
    "actuator",
    "twin",
    "rig",
    "operator",
)
COLUMNS += ("reference", "profile", "starred", "complete", "recovered", "imported", "problem", *Metrics.model_fields)
"""What may be sorted by: columns of the list, and metrics."""


def matching(recordings: Iterable[Recording], search: str) -> list[Recording]:
    """Those in which every word of `search` stands somewhere, small or capital."""
    words = search.casefold().split()
    return [found for found in recordings if all(word in _text(found) for word in words)]


def ordered(recordings: Iterable[Recording], sort: str) -> list[Recording]:
    """By the column `sort`, falling with a "-" before it; what has no value comes last either way.

    Raises ParameterError when there is no such column.
    """
    column, falling = sort.removeprefix("-"), sort.startswith("-")
    if column not in COLUMNS:
        raise ParameterError(f"sort = {sort[:40]!r} is none of {', '.join(COLUMNS)}")
    rows = [(_value(found, column), found) for found in recordings]
    known = sorted((row for row in rows if row[0] is not None), key=lambda row: row[0], reverse=falling)
    return [found for _, found in known] + [found for value, found in rows if value is None]


def _text(found: Recording) -> str:
    parts = (found.id, found.name, *found.tags, found.notes, found.operator, found.actuator, found.reference)
    return "\n".join((*parts, *(mark.label for mark in found.bookmarks))).casefold()


def _value(found: Recording, column: str) -> Any:
    if column in Metrics.model_fields:
        return getattr(found.metrics, column) if found.metrics else None
    value = getattr(found, column)
    return value.casefold() if isinstance(value, str) else value
