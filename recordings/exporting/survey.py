"""The first of two looks at a recording's chunks: which rows there are, what is known, and where each chunk begins."""

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from functools import reduce

import numpy as np

from controller.arrays import Values
from recordings.format.chunks import Chunks, common

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
