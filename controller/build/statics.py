"""The static map of a rod model as the kernels use it: exact under gravity, too."""

import itertools
import math
from functools import lru_cache

import numpy as np

from controller.arrays import Array, Mask, Words
from controller.build.equilibrium import body_of
from controller.build.rod import build_rod
from controller.kernels.model.equilibrium import Scratch, equilibrium, make_scratch
from controller.kernels.model.polygon import Polygon, admissible
from controller.kernels.model.rod import RodModel
from controller.kernels.model.statics import StaticMap, Statics, is_linear, tip_angles_of, tips_of
from controller.schema.actuator import Actuator
from controller.schema.parameters import ControllerParameters

SEED_GRID = 41
"""Points a side of the grid of starts for the inverse: 3 mN m, some 10 mm at the tip."""
START_GRID = 33
"""Points a side of the grid of poses under gravity; odd, so that one of them is the rest."""
STAGES = 4
"""Torques go from one of these to the next in this many stages: each then begins near the pose that it leads to."""
BEND_GRID = 61
"""Torques a side at which the bend limit is looked at."""


def build_statics(model: RodModel, u_max: float) -> Statics:
    """Static map of `model` for torques up to `u_max` [N m]; beyond them it begins farther off."""
    statics = Statics(
        L=model.L,
        rest=model.rest,
        compliance=model.compliance,
        body=body_of(model, model.T_theta, model.stiffening),
        u_max=u_max,
        starts=np.zeros((0, 0, model.L.size)),
    )
    return statics._replace(starts=_starts(statics)) if model.g.any() else statics


def build_static_map(model: RodModel, actuator: Actuator, controller: ControllerParameters) -> StaticMap:
    """Static map of `model` over the torques of `actuator`, with a grid of starts for the inverse."""
    statics = build_statics(model, actuator.u_max)
    polygon = build_polygon(actuator, statics)
    side = np.linspace(-actuator.u_max, actuator.u_max, SEED_GRID)
    inside = np.array([[admissible(polygon, u1, u2) for u2 in side] for u1 in side])
    grid, beside = side[np.argwhere(inside)], _neighbours(inside)
    tips = np.zeros_like(grid)
    tips_of(statics, grid, make_scratch(model.L.size), tips)
    ways = np.linalg.norm(tips[beside] - tips[:, None], axis=2)
    return StaticMap(
        statics=statics,
        polygon=polygon,
        epsilon=controller.epsilon,
        rcond_min=controller.rcond_min,
        seeds=grid,
        seed_tips=tips,
        beside=beside,
        spacing=float(side[1] - side[0]),
        reach=float(ways[beside >= 0].max(initial=0.0)),
    )


def _neighbours(inside: Mask) -> Words:
    """For each point of the grid that is inside (n,n) its neighbours (k,8) among those that are, counted along rows."""
    number = np.pad(np.where(inside, np.cumsum(inside).reshape(inside.shape) - 1, -1), 1, constant_values=-1)
    steps = [step for step in itertools.product((0, 1, 2), repeat=2) if step != (1, 1)]
    rows, columns = inside.shape
    around = [number[i : i + rows, j : j + columns][inside] for i, j in steps]
    return np.stack(around, axis=1)


def build_polygon(actuator: Actuator, statics: Statics) -> Polygon:
    """Admissible torques of `actuator`: the tip angle of its static poses keeps to bend_max."""
    normals = np.array([[1.0, 0.0], [0.0, 1.0], statics.compliance[-1]])
    bounds = np.array([actuator.u_max, actuator.u_max, _bend_bound(actuator, statics)])
    open_polygon = Polygon(normals, bounds, np.zeros((0, 2)))
    corners = []
    for first, second in itertools.combinations(range(3), 2):
        for sign, other in itertools.product((-1.0, 1.0), repeat=2):
            sides = np.array([sign * bounds[first], other * bounds[second]])
            corner = np.linalg.solve(normals[[first, second]], sides)
            if admissible(open_polygon, corner[0], corner[1]):
                corners.append(corner)
    corners.sort(key=lambda corner: math.atan2(corner[1], corner[0]))
    return Polygon(normals, bounds, np.array(corners))


def _bend_bound(actuator: Actuator, statics: Statics) -> float:
    """Bound [rad] of the slope at rest times u within which the tip angle itself keeps to bend_max from that at rest.

    Without gravity they are one and the same; with it the bound is by one cell of a grid on the safe side.
    """
    if is_linear(statics):
        return actuator.bend_max
    side = np.linspace(-actuator.u_max, actuator.u_max, BEND_GRID)
    u = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    theta = np.zeros(len(u))
    tip_angles_of(statics, u, make_scratch(statics.L.size), theta)
    straight = np.abs(u @ statics.compliance[-1])
    over = np.abs(theta - statics.rest[-1]) > actuator.bend_max
    cell = float(np.abs(statics.compliance[-1]).sum() * (side[1] - side[0]))
    return max(cell, float(straight[over].min()) - cell) if over.any() else float(straight.max())


@lru_cache(maxsize=8)
def static_map(actuator: Actuator, controller: ControllerParameters) -> StaticMap:
    """The observer's static map of `actuator`, made once for each; nobody writes into it."""
    model = build_rod(actuator, controller.rods, omega_B=controller.omega_B, zeta_B=controller.zeta_B)
    return build_static_map(model, actuator, controller)


def scratch_for(smap: StaticMap) -> Scratch:
    """Scratch of one caller of `smap`."""
    return make_scratch(smap.statics.L.size)


def _starts(statics: Statics) -> Array:
    """Poses (n,n,N) [rad] that follow from the rest as u1 rises first, then u2."""
    side, middle = np.linspace(-statics.u_max, statics.u_max, START_GRID), START_GRID // 2
    scratch, found = make_scratch(statics.L.size), np.empty((START_GRID, START_GRID, statics.L.size))
    found[middle, middle] = statics.rest
    outward = [*((n, -1) for n in range(middle + 1, START_GRID)), *((n, 1) for n in range(middle - 1, -1, -1))]
    for n, back in outward:
        _lead(statics, found[n + back, middle], (side[n + back], 0.0), (side[n], 0.0), scratch)
        found[n, middle] = scratch.theta
    for row, (n, back) in itertools.product(range(START_GRID), outward):
        _lead(statics, found[row, n + back], (side[row], side[n + back]), (side[row], side[n]), scratch)
        found[row, n] = scratch.theta
    return found


def _lead(
    statics: Statics, theta: Array, begin: tuple[float, float], end: tuple[float, float], scratch: Scratch
) -> None:
    """Where the pose theta (N,) [rad] at torques `begin` gets as they go to `end` [N m], in scratch.theta."""
    scratch.theta[:] = theta
    for share in np.arange(1, STAGES + 1) / STAGES:
        u1, u2 = (a + share * (b - a) for a, b in zip(begin, end, strict=True))
        equilibrium(statics.body, u1, u2, scratch)
