"""Two looks at a recording's chunks: which rows there are and where each chunk begins; then rows of a window.

Those come piece by piece; the chunks may stand in any order.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import reduce

import numpy as np

from controller.arrays import Values
from recordings.format.chunks import Chunks, Part, common

Piece = tuple[Values, Mapping[str, Part]]
"""Times (n,) since the start [ns] of the rows, and of each entity what it holds at some or all of them."""
NEVER = np.iinfo(np.int64).max


@dataclass(frozen=True)
class Survey:
    """What the second look needs to know beforehand."""

    components: Mapping[str, str]
    """The entities that were looked at, each with the component that has its numbers."""
    rows: Values
    """Times (n,) since the start [ns] of the rows that are whole, rising."""
    known: Mapping[str, Values]
    """Which numbers of an entity's rows have a value anywhere, (width,) of bool; entities without rows are left out."""
    ahead: Values
    """The earliest time [ns] in chunk i and all after it, (chunks + 1,): before it nothing more will come."""


def surveyed(chunks: Chunks, components: Mapping[str, str], dense: set[str]) -> Survey:
    """Look at the entities in `components`; a row is whole if all of those in `dense` have it."""
    times: dict[str, list[Values]] = defaultdict(list)
    known: dict[str, Values] = {}
    starts = []
    for entity, part in chunks.parts(components):
        starts.append(part.t.min(initial=NEVER))
        if len(part.t):
            seen = np.asarray(~np.isnan(part.values).all(axis=0))
            known[entity] = seen | known[entity] if entity in known else seen
        if entity in dense:
            times[entity].append(part.t.copy())
    clocks = [np.sort(np.concatenate(times[entity] or [np.empty(0, np.int64)])) for entity in dense]
    ahead = np.minimum.accumulate(np.array([*starts, NEVER])[::-1])[::-1]
    return Survey(components, reduce(common, clocks), known, ahead)


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
