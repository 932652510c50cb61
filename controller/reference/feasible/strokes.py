"""Strokes that are followed one after another, with travel between the end of one and the start of the next."""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from controller.kernels.model.statics import StaticMap
from controller.reference.feasible.bounds import Limits
from controller.reference.feasible.travel import Pose, travel
from controller.reference.feasible.within_limits import Followed, together

TOLD_MAX = 3
"""Changes of strokes that are told one by one."""


def one_after_another(smap: StaticMap, strokes: list[Followed], limits: Limits, dt: float) -> Followed:
    """All `strokes`, each from rest to rest, and between two of them the way through u, within `limits`.

    Raises ParameterError where there is none.
    """
    if len(strokes) == 1:
        return strokes[0]
    rows = strokes[:1]
    for before, after in pairwise(strokes):
        rows += [way_between(smap, before, after, limits, dt), after]
    said = [f"stroke {i + 1}: {text}" for i, stroke in enumerate(strokes) for text in stroke.said]
    more = [f"{len(said) - TOLD_MAX} more strokes likewise"] if len(said) > TOLD_MAX else []
    return replace(together(rows), said=(*said[:TOLD_MAX], *more))


def way_between(smap: StaticMap, before: Followed, after: Followed, limits: Limits, dt: float) -> Followed:
    """From the last row of one stroke on to the first of the next, which would be the next row."""
    p, u = travel(smap, Pose(before.p[-1], before.u[-1]), Pose(after.p[0], after.u[0]), limits, dt)
    rows = len(p)
    return Followed(p, u, np.tile(before.wished[-1], (rows, 1)), np.zeros(rows), np.ones(rows, bool))
