"""Rows of a path as the page gets them: as many and as exact as a picture needs."""

from typing import Any

import numpy as np
import numpy.typing as npt

from controller.arrays import Array

POINTS = 2000
"""Most points of a path that the page gets."""

Indices = np.ndarray[Any, np.dtype[np.intp]]


def evenly(count: int, most: int = POINTS) -> Indices:
    """Indices of at most `most` of `count` rows, evenly chosen, first and last among them."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(np.intp))


def times(t: npt.NDArray[np.floating[Any]]) -> list[float]:
    """Times t (n,) [s] to a tenth of a millisecond."""
    return [round(value, 4) for value in t.tolist()]


def points(p: Array) -> list[tuple[float, float]]:
    """Rows p (n, 2) [m] to a hundredth of a millimetre."""
    return [(round(x, 5), round(y, 5)) for x, y in p.tolist()]
