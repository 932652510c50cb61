"""The static poses of a grid of torques under gravity, and for which of them there is more than one."""

import itertools
from collections.abc import Iterator

import numpy as np

from controller.arrays import Array, Mask
from controller.kernels.model.equilibrium import lead_pose, make_scratch
from controller.kernels.model.statics import Statics

START_GRID = 33
"""Points a side of the grid; odd, so that one of them is the rest."""
APART = 0.3
"""Poses of the same torques of which some angle differs by more are two [rad]."""
SWEEPS = 3
"""To and fro along both torques: after the second no more are found."""

Place = tuple[int, int]


def start_poses(statics: Statics) -> Array:
    """Poses (n,n,N) [rad] that follow from the rest as u1 rises first, then u2."""
    side, middle = _side(statics), START_GRID // 2
    scratch, found = make_scratch(statics.L.size), np.empty((START_GRID, START_GRID, statics.L.size))
    found[middle, middle] = statics.rest
    outward = [*((n, -1) for n in range(middle + 1, START_GRID)), *((n, 1) for n in range(middle - 1, -1, -1))]
    for n, back in outward:
        lead_pose(statics.body, found[n + back, middle], (side[n + back], 0.0), (side[n], 0.0), scratch)
        found[n, middle] = scratch.theta
    for row, (n, back) in itertools.product(range(START_GRID), outward):
        lead_pose(statics.body, found[row, n + back], (side[row], side[n + back]), (side[row], side[n]), scratch)
        found[row, n] = scratch.theta
    return found


def two_poses(statics: Statics) -> Mask:
    """At which torques of the grid (n,n) the arm may be in another pose than that of `starts`, by the way it came.

    Every pose is led from neighbour to neighbour, over the ends of where it holds and back: what is arrived at beside
    the known pose is another one, and is led on in turn.
    """
    side, scratch = _side(statics), make_scratch(statics.L.size)
    known, other = statics.starts, statics.starts.copy()
    two = np.zeros(known.shape[:2], np.bool_)
    for _, (here, there) in itertools.product(range(SWEEPS), _neighbours()):
        begin, end = (side[here[0]], side[here[1]]), (side[there[0]], side[there[1]])
        for pose in (known[here], other[here]) if two[here] else (known[here],):
            if two[there]:
                break
            lead_pose(statics.body, pose, begin, end, scratch)
            if np.abs(scratch.theta - known[there]).max() > APART:
                two[there], other[there] = True, scratch.theta
    return two


def _neighbours() -> Iterator[tuple[Place, Place]]:
    """From each point of the grid to the next, along each line to its end and back."""
    up = range(1, START_GRID)
    for line, (back, way) in itertools.product(range(START_GRID), ((-1, up), (1, range(START_GRID - 2, -1, -1)))):
        yield from (((n + back, line), (n, line)) for n in way)
        yield from (((line, n + back), (line, n)) for n in way)


def _side(statics: Statics) -> Array:
    return np.linspace(-statics.u_max, statics.u_max, START_GRID)
