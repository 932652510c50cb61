"""The static map of the actuator: torques to angles, and to the tip.

Paper, "Quasi-Static Feedforward Control": theta = K_theta^-1 T_theta u is linear in the angles, with rest angles other
than zero, too. Where pressure stiffens the hinges it is not, but each bend still has its own torque alone. Under
gravity the equilibrium itself is solved, from the nearest of a grid of poses that follow from the rest by raising the
torques. So a pose depends on u alone. Neither is in the paper.
"""

from collections.abc import Sequence

import numpy as np

from controller.arrays import Array, Pair, Words
from controller.kernels.compiled import inlined, kernel
from controller.kernels.group import Group
from controller.kernels.model.equilibrium import Body, Scratch, equilibrium, under_pressure
from controller.kernels.model.polygon import Polygon
from controller.kernels.model.rod import RodModel, RodState, sine_cosine

TORN = 1.5
"""Tip angles of neighbours in the grid of poses that are further apart are on two branches [rad]."""


class Statics(Group):
    """The static map of a chain of N rods."""

    L: Array
    """Without pressure (N,) [m]."""
    rest: Array
    """(N,) [rad]."""
    compliance: Array
    """K_theta^-1 T_theta at rest (N,2) [rad/(N m)]."""
    body: Body
    u_max: float
    """The grid's torques go from -u_max to u_max [N m]."""
    starts: Array
    """Poses (n,n,N) [rad] of a grid over u1, u2; empty without gravity."""


class StaticMap(Group):
    """The static map, where it may be used, and a grid of its points to start the inverse from."""

    statics: Statics
    polygon: Polygon
    epsilon: float
    rcond_min: float
    seeds: Array
    """Admissible torques (n,2) [N m]."""
    seed_tips: Array
    """Their tips (n,2) [m]."""
    beside: Words
    """Their neighbours in the grid (n,8), -1 where that is not admissible."""
    spacing: float
    """Of the grid [N m]."""
    reach: float
    """The longest way of the tip from one of them to a neighbour [m]."""


class Places(Group):
    """Material points of the backbone, given by arc length, as rod index and distance from that rod's centre."""

    rod: Words
    """(n,) index."""
    offset: Array
    """(n,) along the rod, towards the tip [m]."""


def places(model: RodModel, arc: Array) -> Places:
    """Where the arc lengths `arc` (n,) [m] lie on the rods of `model`; a joint counts to the rod before it."""
    ends = np.cumsum(model.L)
    rod = np.minimum(np.searchsorted(ends, arc - 1e-9 * ends[-1]), model.L.size - 1).astype(np.int64)
    return Places(rod, arc - (ends - model.L + model.arm)[rod])


def chosen(at: Places, which: Sequence[int]) -> Places:
    """Those of the points, counted from 0."""
    return Places(at.rod[list(which)], at.offset[list(which)])


def at_rest(model: RodModel) -> RodState:
    """The unactuated equilibrium, without motion: straight along +x where nothing bends the body."""
    state = RodState(np.zeros((3, model.L.size)), np.zeros((3, model.L.size)))
    pose(model, model.rest, state.q)
    return state


@kernel
def pose(model: RodModel, theta: Array, out_q: Array) -> None:
    """Centres and angles (3,N) of the chain with the angles theta (N,) [rad].

    phi_H(q) = 0: paper, "Constrained Dynamic Model".
    """
    x = y = 0.0
    for i in range(theta.size):
        s, c = sine_cosine(theta[i])
        out_q[0, i], out_q[1, i], out_q[2, i] = x + model.arm[i] * c, y + model.arm[i] * s, theta[i]
        x += model.L[i] * c
        y += model.L[i] * s


@kernel
def is_linear(statics: Statics) -> bool:
    """Whether the angles are linear in u, as in the paper, "Quasi-Static Feedforward Control".

    Without gravity, and where no pressure stiffens the hinges.
    """
    return statics.starts.size == 0 and statics.body.stiffening.shape[0] == 0


@kernel
def static_pose(statics: Statics, u1: float, u2: float, scratch: Scratch) -> None:
    """Angles of the static pose at u [N m].

    theta = K_theta^-1 T_theta u: paper, "Quasi-Static Feedforward Control". Gravity is not in the paper.
    In place: scratch, whose theta (N,) [rad] it is.
    """
    theta = scratch.theta
    if is_linear(statics):
        for i in range(theta.size):
            theta[i] = statics.rest[i] + statics.compliance[i, 0] * u1 + statics.compliance[i, 1] * u2
        return
    if statics.starts.size == 0:
        return bends(statics.body, u1, u2, scratch)
    between_starts(statics, u1, u2, theta)
    equilibrium(statics.body, u1, u2, scratch)


@kernel
def bends(body: Body, u1: float, u2: float, scratch: Scratch) -> None:
    """Angles of the static pose at u [N m] without gravity: each hinge bends by the torque beyond it over its k.

    Stiffness under pressure is not in the paper. In place: scratch, whose theta (N,) [rad] it is.
    """
    theta, k = scratch.theta, under_pressure(body, u1, u2, scratch).k
    torque = 0.0
    for i in range(theta.size - 1, -1, -1):
        torque += body.T_theta[i, 0] * u1 + body.T_theta[i, 1] * u2
        theta[i] = body.bend[i] + torque / k[i]
    for i in range(1, theta.size):
        theta[i] += theta[i - 1]


@kernel
def between_starts(statics: Statics, u1: float, u2: float, out_theta: Array) -> None:
    """Angles (N,) between the four poses of the grid about u [N m], or about the nearest point of the grid.

    Where one of the four is on another branch, as beyond a snap-through, the nearest one alone. Not in the paper, which
    has no gravity.
    """
    last = statics.starts.shape[0] - 1
    a_1 = min(max(0.5 * (u1 / statics.u_max + 1.0), 0.0), 1.0) * last
    a_2 = min(max(0.5 * (u2 / statics.u_max + 1.0), 0.0), 1.0) * last
    n_1, n_2 = max(0, min(int(a_1), last - 1)), max(0, min(int(a_2), last - 1))  # 0 where u is nan
    a_1, a_2 = a_1 - n_1, a_2 - n_2
    low, high = statics.starts[n_1], statics.starts[n_1 + 1]
    torn = max(
        abs(low[n_2 + 1, -1] - low[n_2, -1]),
        abs(high[n_2 + 1, -1] - high[n_2, -1]),
        abs(high[n_2, -1] - low[n_2, -1]),
        abs(high[n_2 + 1, -1] - low[n_2 + 1, -1]),
    )
    if torn > TORN:
        a_1, a_2 = round(a_1), round(a_2)
    for i in range(out_theta.size):
        below = low[n_2, i] + a_2 * (low[n_2 + 1, i] - low[n_2, i])
        above = high[n_2, i] + a_2 * (high[n_2 + 1, i] - high[n_2, i])
        out_theta[i] = below + a_1 * (above - below)


@kernel
def static_tip(statics: Statics, u1: float, u2: float, scratch: Scratch) -> Pair:
    """Static tip p(u) = sum L_i (cos theta_i, sin theta_i) [m] (paper, "Quasi-Static Feedforward Control": p_model).

    In place: scratch.
    """
    static_pose(statics, u1, u2, scratch)
    x = y = 0.0
    for i in range(statics.L.size):
        s, c = sine_cosine(scratch.theta[i])
        L = length_of(statics, i, abs(u1), abs(u2))
        x += L * c
        y += L * s
    return x, y


@inlined
def length_of(statics: Statics, i: int, level_1: float, level_2: float) -> float:
    """Length of rod i under pressure [m], by levels [N m] as of `under_levels`. Not in the paper: see there."""
    share = statics.body.stretching
    return statics.L[i] * (1.0 + share[i, 0] * level_1 + share[i, 1] * level_2) if share.shape[0] > 0 else statics.L[i]


@kernel
def tip_angles_of(statics: Statics, u: Array, scratch: Scratch, out_theta: Array) -> None:
    """Angles of the last rod (n,) [rad] in the static poses at u (n,2) [N m].

    Paper, "Quasi-Static Feedforward Control". In place: scratch.
    """
    for n in range(u.shape[0]):
        static_pose(statics, u[n, 0], u[n, 1], scratch)
        out_theta[n] = scratch.theta[-1]


@kernel
def tips_of(statics: Statics, u: Array, scratch: Scratch, out_p: Array) -> None:
    """Static tips (n,2) [m] at u (n,2) [N m].

    Paper, "Quasi-Static Feedforward Control": p_model. In place: scratch.
    """
    for n in range(u.shape[0]):
        out_p[n, 0], out_p[n, 1] = static_tip(statics, u[n, 0], u[n, 1], scratch)


@kernel
def points_on(q: Array, at: Places, out_points: Array) -> None:
    """Positions (n,2) [m] of the material points `at` in the pose q (3,N).

    Not in the paper, whose points are the rods' centres and the tip.
    """
    for j in range(at.rod.size):
        i = at.rod[j]
        s, c = sine_cosine(q[2, i])
        out_points[j, 0] = q[0, i] + at.offset[j] * c
        out_points[j, 1] = q[1, i] + at.offset[j] * s


@kernel
def tip_of(model: RodModel, q: Array) -> Pair:
    """Distal end of the last rod [m] in the pose q (3,N) (paper, "Dynamic observer": p_model)."""
    last = model.L.size - 1
    s, c = sine_cosine(q[2, last])
    beyond = model.L[last] - model.arm[last]
    return q[0, last] + beyond * c, q[1, last] + beyond * s
