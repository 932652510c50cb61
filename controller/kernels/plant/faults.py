"""Faults that an operator injects into the twin: noisy, lost, displaced and frozen markers, broken pneumatics.

They have a random generator of their own: with all of them off, and of what they leave alone, the twin keeps every bit.
"""

from typing import NamedTuple

import numpy as np

from controller.arrays import Array
from controller.kernels.compiled import kernel
from controller.kernels.plant.noise import normal_pair, uniform

NOISE, SAMPLE_LOSS, MARKER_LOSS, JUMP_X, JUMP_Y = range(5)
LOST = -1
"""Time of capture of a sample that is never delivered."""


class Faults(NamedTuple):
    """What is injected from the next sample on; written by the link's thread, one number after the other."""

    values: Array
    """(5,) added standard deviation of each coordinate [m]; probability to lose a sample, and to lose a marker; what
    is added to x and y [m]."""
    rods: np.ndarray
    """(1,) int64: bit i-1 set: noise, jump and loss of markers meet the marker of rod i."""
    freeze: np.ndarray
    """(1,) int64: a `Freeze`."""
    pneumatics: np.ndarray
    """(3,) int64: bits of stuck sensors, bits of stuck spools, whether the supply is lost (kernels/plant/valve.py)."""
    seed: np.ndarray
    """(1,) uint64 state of the faults' own randomness."""


@kernel
def sample_lost(faults):
    """Whether the sample that is taken now gets lost whole."""
    share = faults.values[SAMPLE_LOSS]
    return share > 0.0 and uniform(faults.seed) <= share


@kernel
def spoil(faults, points):
    """Displace the markers `points` (n,2) [m] in place, add noise, and make lost ones nan."""
    noise, share = faults.values[NOISE], faults.values[MARKER_LOSS]
    for i in range(points.shape[0]):
        if not faults.rods[0] >> i & 1:
            continue
        points[i, 0] += faults.values[JUMP_X]
        points[i, 1] += faults.values[JUMP_Y]
        if noise > 0.0:
            x, y = normal_pair(faults.seed)
            points[i, 0] += noise * x
            points[i, 1] += noise * y
        if share > 0.0 and uniform(faults.seed) <= share:
            points[i, 0] = points[i, 1] = np.nan
