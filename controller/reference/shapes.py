"""The paper's shapes as pure geometry [m], about their own origin: no place, no time.

Sizes are the paper's ("Experimental Results", Tasks 1 to 4). Where it gives none the number is marked ours.
"""

import math

import numpy as np

from controller.arrays import Array

BOX = 30e-3
"""Side of the square that bounds the digits 2 to 9, and height of the 1."""
ELLIPSE = (30e-3, 60e-3)
"""The 0, upright (which way it stands is ours)."""
SIZE = 60e-3
"""Diameter of the circle, length of the lines."""
DIAMOND = 56e-3
"""Half-diagonal of the four steps (ours)."""
VU_WIDTH, VU_HEIGHT, VU_LENGTH = 55e-3, 25e-3, 125e-3
SWEEP_PIVOT, SWEEP_ANGLE = (-30e-3, -140e-3), math.radians(25.0)
"""The sweep is an arc about this point, this far to either side (ours: the paper only names it)."""

DIGITS = {
    1: ((0, 1), (0, -1)),
    2: ((-1, 1), (1, 1), (1, 0), (-1, 0), (-1, -1), (1, -1)),
    3: ((-1, 1), (1, 1), (1, 0), (-1, 0), (1, 0), (1, -1), (-1, -1)),
    4: ((-1, 1), (-1, 0), (1, 0), (1, 1), (1, -1)),
    5: ((1, 1), (-1, 1), (-1, 0), (1, 0), (1, -1), (-1, -1)),
    6: ((1, 1), (-1, 1), (-1, -1), (1, -1), (1, 0), (-1, 0)),
    7: ((-1, 1), (1, 1), (1, -1)),
    8: ((1, 1), (-1, 1), (-1, 0), (1, 0), (1, -1), (-1, -1), (-1, 0), (1, 0), (1, 1)),
    9: ((1, 0), (-1, 0), (-1, 1), (1, 1), (1, -1), (-1, -1)),
}
"""One stroke each, in half boxes (strokes ours, as on a seven-segment display): the 8 is 180 mm long and the 1 30 mm,
which in 10 s are the paper's 18 and 3 mm/s."""


def digit(value: int) -> Array:
    """Vertices (n, 2) of a digit 0..9."""
    if value == 0:
        phi = np.linspace(0.0, 2.0 * math.pi, 3601)
        return 0.5 * np.column_stack([-ELLIPSE[0] * np.sin(phi), ELLIPSE[1] * np.cos(phi)])
    return 0.5 * BOX * np.array(DIGITS[value], dtype=float)


def vu() -> Array:
    """Vertices (n, 2) of "VU" in one stroke, lower left corner of its bounds at the origin.

    Letters of equal width w, the U a half circle below two stems (ours); w follows from the paper's three numbers:
    sqrt(4 h^2 + w^2) for the V, W - 2 w from letter to letter, 2 h - w + pi w/2 for the U, in sum the paper's length.
    """
    rest = VU_LENGTH - VU_WIDTH - 2.0 * VU_HEIGHT
    c = 3.0 - 0.5 * math.pi
    w = (math.sqrt((c * rest) ** 2 + (c * c - 1.0) * (4.0 * VU_HEIGHT**2 - rest**2)) - c * rest) / (c * c - 1.0)
    phi = np.linspace(math.pi, 2.0 * math.pi, 1801)
    bowl = np.column_stack([VU_WIDTH - 0.5 * w * (1.0 - np.cos(phi)), 0.5 * w * (1.0 + np.sin(phi))])
    V = [(0.0, VU_HEIGHT), (0.5 * w, 0.0), (w, VU_HEIGHT)]
    return np.vstack([V, (VU_WIDTH - w, VU_HEIGHT), bowl, (VU_WIDTH, VU_HEIGHT)])


def lengths(path: Array) -> Array:
    """Arc length (n,) at each vertex of `path` (n, 2)."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])


def along(path: Array, share: Array) -> Array:
    """Points (m, 2) at the shares (m,) 0..1 of the length of `path` (n, 2)."""
    arc = lengths(path)
    return np.column_stack([np.interp(share * arc[-1], arc, path[:, j]) for j in range(2)])


def circle(phase: Array) -> Array:
    """Points (m, 2) at the phases (m,) [turns], counter-clockwise from the top, as a 0 is written (ours)."""
    return 0.5 * SIZE * np.column_stack([-np.sin(2.0 * math.pi * phase), np.cos(2.0 * math.pi * phase)])


def vertical(phase: Array) -> Array:
    """Points (m, 2) of the line along y, harmonic in the phases (m,) [turns], from the middle upwards."""
    return 0.5 * SIZE * np.column_stack([np.zeros(phase.shape), np.sin(2.0 * math.pi * phase)])


def horizontal(phase: Array) -> Array:
    """Points (m, 2) of the line along x, from the middle to the right."""
    return vertical(phase)[:, ::-1]


def sweep(phase: Array) -> Array:
    """Points (m, 2) of the arc through the origin about its pivot, harmonic in the phases (m,) [turns]."""
    turn = SWEEP_ANGLE * np.sin(2.0 * math.pi * phase)
    x, y = SWEEP_PIVOT
    c, s = np.cos(turn), np.sin(turn)
    return np.column_stack([x - c * x + s * y, y - s * x - c * y])


def diamond() -> Array:
    """Corners (4, 2) in the order of the steps: top first and clockwise, so the left one comes last."""
    return DIAMOND * np.array([(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)])
