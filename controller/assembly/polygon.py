"""The admissible torques of an actuator as a convex polygon, which the kernels know."""

import itertools
import math

import numpy as np

from controller.arrays import Array
from controller.assembly.poses import START_GRID, two_poses
from controller.kernels.model.equilibrium import make_scratch
from controller.kernels.model.polygon import Polygon, admissible
from controller.kernels.model.statics import Statics, is_linear, tip_angles_of
from controller.schema.actuator import Actuator

BEND_GRID = 61
"""Torques a side at which the bend limit is looked at."""
MARGIN = 1.5
"""How far from what is not admissible a side stays [points of the grid on which that was looked for]."""
NEAREST = 1e-3
"""No side comes nearer to rest than this share of u_max."""
DIRECTIONS = 64
"""In which a side may cut off what is not admissible."""


def build_polygon(actuator: Actuator, statics: Statics) -> Polygon:
    """Admissible torques of `actuator`: the tip angle of its static poses keeps to bend_max, and each has one pose.

    Where the map is linear that is the box cut by two lines. Else sides are put until what is not admissible is
    outside.
    """
    u_max = actuator.u_max
    normals, bounds = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]), np.full(4, u_max)
    if is_linear(statics):
        slope = statics.compliance[-1]
        normals, bounds = np.vstack([normals, slope, -slope]), np.append(bounds, [actuator.bend_max] * 2)
    else:
        normals, bounds = _cut(normals, bounds, *_not_admissible(actuator, statics))
    return Polygon(normals, bounds, _corners(normals, bounds))


def _not_admissible(actuator: Actuator, statics: Statics) -> tuple[Array, Array]:
    """Torques (n,2) [N m] that bend too far or have two poses, and how far a side stays off each (n,) [N m].

    An arm that snaps into the pose that the map does not have is out of the feedback's hands. Where there are two
    at rest already, none can be kept from it.
    """
    u = _grid(statics.u_max, BEND_GRID)
    theta = np.zeros(len(u))
    tip_angles_of(statics, u, make_scratch(statics.L.size), theta)
    over = u[np.abs(theta - statics.rest[-1]) > actuator.bend_max]
    two = two_poses(statics) if statics.starts.size > 0 else np.zeros((START_GRID, START_GRID), np.bool_)
    if two[START_GRID // 2, START_GRID // 2]:
        two[:] = False
    snapping = _grid(statics.u_max, START_GRID)[two.ravel()]
    sides = np.repeat([BEND_GRID, START_GRID], [len(over), len(snapping)])
    return np.vstack([over, snapping]), MARGIN * 2.0 * statics.u_max / (sides - 1)


def _cut(normals: Array, bounds: Array, bad: Array, off: Array) -> tuple[Array, Array]:
    """Sides on top of `normals` (m,2), `bounds` (m,) that leave out torques `bad` (n,2) and keep `off` (n,) from them.

    One after the other, each for the one that is nearest to rest, in the direction that leaves the most; of a side
    that is there already half of `off` is enough. One so near to rest that no side can leave it out stays.
    """
    angle = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    ways, kept = np.stack([np.cos(angle), np.sin(angle)], axis=-1), _grid(float(bounds[0]), BEND_GRID)
    order = np.argsort(np.linalg.norm(bad, axis=1), kind="stable")
    for u, margin in zip(bad[order], off[order], strict=True):
        if (normals @ u - 0.5 * margin * np.abs(normals).sum(axis=1) > bounds).any():
            continue
        at = ways @ u - margin * np.abs(ways).sum(axis=1)
        left = np.where(at > NEAREST * bounds[0], (kept @ ways.T <= at).sum(axis=0), -1)
        best = int(np.argmax(left))
        if left[best] > 0:
            normals, bounds = np.vstack([normals, ways[best]]), np.append(bounds, at[best])
            kept = kept[kept @ ways[best] <= at[best]]
    return normals, bounds


def _corners(normals: Array, bounds: Array) -> Array:
    """Where two sides meet within all others (n,2) [N m], counter-clockwise."""
    open_polygon, corners = Polygon(normals, bounds, np.zeros((0, 2))), []
    for pair in itertools.combinations(range(len(bounds)), 2):
        sides = normals[list(pair)]
        if abs(np.linalg.det(sides)) > 1e-9 * np.prod(np.linalg.norm(sides, axis=1)):
            corner = np.linalg.solve(sides, bounds[list(pair)])
            if admissible(open_polygon, corner[0], corner[1]):
                corners.append(corner)
    corners.sort(key=lambda corner: math.atan2(corner[1], corner[0]))
    apart = [np.abs(corner - corners[n - 1]).max() > 1e-9 * bounds[0] for n, corner in enumerate(corners)]
    return np.array([corner for corner, new in zip(corners, apart, strict=True) if new])


def _grid(u_max: float, side: int) -> Array:
    line = np.linspace(-u_max, u_max, side)
    return np.stack(np.meshgrid(line, line, indexing="ij"), axis=-1).reshape(-1, 2)
