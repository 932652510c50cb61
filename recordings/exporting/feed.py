"""The second look at a recording's chunks: rows of a window, piece by piece, whatever the order of the chunks."""

from collections import defaultdict
from collections.abc import Iterator, Mapping

import numpy as np

from controller.arrays import Values
from recordings.exporting.survey import Survey
from recordings.format.chunks import Chunks, Part

Piece = tuple[Values, Mapping[str, Part]]
"""Times (n,) since the start [ns] of the rows, and of each entity what it holds at some or all of them."""


def feed(chunks: Chunks, survey: Survey, rows: Values, most: int) -> Iterator[Piece]:
    """`rows` (n,) of the survey's, n >= 1, in pieces of `most`; in memory is what a piece still has to wait for."""
    waiting: dict[str, list[Part]] = defaultdict(list)
    done = 0
    for (entity, part), ahead in zip(chunks.parts(survey.components), survey.ahead[1:], strict=True):
        inside = (part.t >= rows[0]) & (part.t <= rows[-1])
        if inside.any():
            waiting[entity].append(part if inside.all() else part.pick(inside))
        ready = int(np.searchsorted(rows, ahead))
        while ready - done >= most:
            piece, done = rows[done : done + most], done + most
            yield piece, {entity: _taken(parts, piece) for entity, parts in waiting.items()}
        if ready == len(rows):
            break
    if done < len(rows):
        yield rows[done:], {entity: _taken(parts, rows[done:]) for entity, parts in waiting.items()}


def _taken(parts: list[Part], rows: Values) -> Part:
    """Take from `parts`, in the order of time, what is not later than the last of `rows`; what is at them."""
    t, tick, values = (np.concatenate([getattr(part, name) for part in parts]) for name in ("t", "tick", "values"))
    order = np.argsort(t, kind="stable")
    whole = Part(t, tick, values).pick(order) if (order[1:] < order[:-1]).any() else Part(t, tick, values)
    end = int(np.searchsorted(whole.t, rows[-1], side="right"))
    parts[:] = [whole.pick(slice(end, None))]
    now = whole.pick(slice(0, end))
    return now.pick(np.isin(now.t, rows, assume_unique=True))
