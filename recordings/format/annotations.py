"""What is noted in a recording beside its rows, at the row that is the newest then.

A new kind is a class here, which passes as it is from who notes it to the file, and a branch in `RrdFile.annotate`.
"""

from dataclasses import dataclass

from recordings.format.messages import Level


@dataclass(frozen=True)
class LogLine:
    """A line of the log; before the first row it stands at the start."""

    text: str
    level: Level = "info"


@dataclass(frozen=True)
class Approach:
    """The ticks [first, end) lead into a run and are no part of it."""

    first: int
    end: int


@dataclass(frozen=True)
class Mark:
    """Bookmark number `n`."""

    n: int
    label: str


Annotation = LogLine | Approach | Mark
