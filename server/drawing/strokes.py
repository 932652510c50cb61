"""A drawing's strokes: between the end of one and the start of the next the pen is lifted, and the tip travels."""

import numpy as np

from controller.arrays import Array
from controller.reference.shapes import lengths
from server.drawing.messages import DrawingBody, Given

MEET = 1e-4
"""Strokes that are this near to one another, end to start, are one [m]."""


def strokes_of(drawing: DrawingBody) -> list[Array]:
    """Points (n, 2) [m] of each stroke of `drawing`, the line that closes it included; those that meet are one.

    A drawing that does not say of which pieces it is, or whose points have times of their own, is one stroke.
    """
    points = np.array(drawing.points)
    if drawing.pieces is None or isinstance(drawing.timing, Given):
        found = [points]
    else:
        parts = np.split(points, np.cumsum([piece.points for piece in drawing.pieces])[:-1])
        found = parts[:1]
        for part in parts[1:]:
            if np.linalg.norm(part[0] - found[-1][-1]) < MEET:
                found[-1] = np.vstack([found[-1], part])
            else:
                found.append(part)
    if drawing.closed and (found[0][0] != found[-1][-1]).any():
        found[-1] = np.vstack([found[-1], found[0][:1]])
    return found


def length_of(strokes: list[Array]) -> float:
    """Of all of them, without what lies between two [m]."""
    return sum(float(lengths(stroke)[-1]) for stroke in strokes)
