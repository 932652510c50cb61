"""Rounding a drawn path: no point goes further than a given radius, straight lines stay straight, ends stay."""

import math

import numpy as np

from controller.arrays import Array
from controller.reference.shapes import along, lengths

HALF_WIDTH = 3.0
"""Half-width of the hat over its mean distance from its middle."""
STEPS = 24
"""Points in half a hat."""
POINTS_MAX = 100_000
"""More points than these are not made: a path so long is rounded coarsely."""


def smoothed(path: Array, radius: float, closed: bool = False) -> Array:
    """Points (m, 2) [m], evenly along `path` (n, 2) [m], each moved to the mean of the path about it.

    The mean is weighted by a hat of half-width w = 3 radius along the path. No point of the path is further from its
    middle than along it, where the mean distance is w / 3, so none is moved further than `radius` [m]. A path that is
    `closed` goes on at its ends, where it has to meet itself; any other is continued by its point reflection.
    """
    if radius <= 0.0:
        return path
    total = float(lengths(path)[-1])
    width = min(HALF_WIDTH * radius, 0.5 * total)
    step = max(width / STEPS, total / POINTS_MAX)
    count = math.ceil(total / step) if step > 0.0 else 1
    p = along(path, np.linspace(0.0, 1.0, count + 1))
    reach = int(width * count / total) if total > 0.0 else 0
    if reach < 2:
        return p
    hat = 1.0 - np.abs(np.arange(1 - reach, reach)) / reach
    longer = continued(p, reach - 1, closed)
    return np.column_stack([np.convolve(longer[:, j], hat / hat.sum(), "valid") for j in range(2)])


def continued(p: Array, rows: int, closed: bool) -> Array:
    """The path p (n, 2) with `rows` more rows at both ends."""
    if closed:
        return np.vstack([p[-1 - rows : -1], p, p[1 : 1 + rows]])
    return np.vstack([2.0 * p[0] - p[rows:0:-1], p, 2.0 * p[-1] - p[-2 : -2 - rows : -1]])
