"""Faults that an operator injects into the twin: noisy, lost, displaced and frozen markers, broken pneumatics.

They have a random generator of their own: with all of them off, and of what they leave alone, the twin keeps every bit.
"""

import numpy as np

from controller.arrays import Array, Seed, Words
from controller.kernels.compiled import kernel
from controller.kernels.group import Group
from controller.kernels.plant.noise import normal_pair, uniform

NOISE, SAMPLE_LOSS, MARKER_LOSS, JUMP_X, JUMP_Y = range(5)
LOST = -1
"""Time of capture of a sample that is never delivered."""


class Faults(Group):
    """What is injected from the next sample on; written by the link's thread, one number after the other."""

    values: Array
    """(5,) added standard deviation of each coordinate [m]; probability to lose a sample, and to lose a marker; what
    is added to x and y [m]."""
    rods: Words
    """(1,) bit i-1 set: noise, jump and loss of markers meet the marker of rod i."""
    freeze: Words
    """(1,) a `Freeze`."""
    pneumatics: Words
    """(3,) bits of stuck sensors, bits of stuck spools, whether the supply is lost (kernels/plant/valve.py)."""
    seed: Seed
    """(1,) state of the faults' own randomness."""


@kernel
def sample_lost(faults: Faults) -> bool:
    """Whether the sample that is taken now gets lost whole. Not in the paper: a fault. In place: faults.seed."""
    share = faults.values[SAMPLE_LOSS]
    return share > 0.0 and uniform(faults.seed) <= share


@kernel
def spoil(faults: Faults, points: Array) -> None:
    """Displace the markers, add noise, and make lost ones nan.

    Not in the paper: faults. In place: faults.seed, points (n,2) [m].
    """
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
