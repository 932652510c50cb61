"""How far the tip reaches: the image of the admissible torques under the observer's static map."""

from typing import NamedTuple

import numpy as np

from controller.arrays import Array
from controller.assembly.statics import scratch_for, static_map
from controller.kernels.model.polygon import Polygon
from controller.kernels.model.statics import StaticMap, tips_of
from controller.schema.parameters import RigParameters


class Reach(NamedTuple):
    """Image of a grid over the admissible torques. Its quads, filled, cover the reach and leave its hole open."""

    u: Array
    """(rows, columns, 2) admissible torques, the polygon's own edges included [N m]."""
    p: Array
    """(rows, columns, 2) static tips [m]."""


def reach_map(parameters: RigParameters, side: int = 61) -> Reach:
    """Reach of the static map over the box and the coupled bend limit, as `side` x `side` points.

    Rows run over u1, columns from the lowest to the highest u2 that goes with it, so no cell is cut by the polygon.
    """
    smap = static_map(parameters.actuator, parameters.controller)
    u1 = np.linspace(*extent(smap.polygon), side)
    low, high = span(smap.polygon, u1)
    share = np.linspace(0.0, 1.0, side)
    u = np.empty((side, side, 2))
    u[..., 0] = u1[:, None]
    u[..., 1] = low[:, None] + share * (high - low)[:, None]
    return Reach(u, static_tips(smap, u))


def extent(polygon: Polygon) -> tuple[float, float]:
    """Lowest and highest admissible u1 [N m]."""
    return float(polygon.corners[:, 0].min()), float(polygon.corners[:, 0].max())


def span(polygon: Polygon, u1: Array) -> tuple[Array, Array]:
    """Lowest and highest admissible u2 (n,) for each u1 (n,) [N m]: every side a u1 + b u2 <= c that bounds u2."""
    low, high = np.full(u1.shape, -np.inf), np.full(u1.shape, np.inf)
    for (a, b), c in zip(polygon.normals, polygon.bounds, strict=True):
        if b > 0.0:
            high = np.minimum(high, (c - a * u1) / b)
        elif b < 0.0:
            low = np.maximum(low, (c - a * u1) / b)
    return low, high


def static_tips(smap: StaticMap, u: Array) -> Array:
    """Static tips (..., 2) [m] under torques u (..., 2) [N m]."""
    flat = np.ascontiguousarray(u, dtype=float).reshape(-1, 2)
    found = np.empty_like(flat)
    tips_of(smap.statics, flat, scratch_for(smap), found)
    return found.reshape(u.shape)
