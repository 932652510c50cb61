"""The static map of the actuator: torques to angles, to the tip; its slope S and its curvature.

Paper, "Quasi-Static Feedforward Control": theta = K_theta^-1 T_theta u is linear in the angles, with rest angles other
than zero, too. Under gravity it is not (and gravity is not in the paper): there the equilibrium itself is solved, from
the nearest of a grid of poses that follow from the rest by raising the torques. So a pose depends on u alone.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from controller.arrays import Array, Pair, Words
from controller.kernels.compiled import kernel
from controller.kernels.model.equilibrium import Body, Scratch, equilibrium, factor, solve
from controller.kernels.model.polygon import Polygon
from controller.kernels.model.rod import RodModel, RodState, sine_cosine

TORN = 1.5
"""Tip angles of neighbours in the grid of poses that are further apart are on two branches [rad]."""


class Statics(NamedTuple):
    """The static map of a chain of N rods."""

    L: Array
    """(N,) [m]."""
    rest: Array
    """(N,) [rad]."""
    compliance: Array
    """K_theta^-1 T_theta at rest (N,2) [rad/(N m)]."""
    body: Body
    u_max: float
    """The grid's torques go from -u_max to u_max [N m]."""
    starts: Array
    """Poses (n,n,N) [rad] of a grid over u1, u2; empty without gravity: there the map is linear."""


class StaticMap(NamedTuple):
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


class Expansion(NamedTuple):
    """Static tip p(u) to second order; suffix j is a derivative with respect to u_j [N m]."""

    x: float
    y: float
    """p(u) [m]."""
    x_1: float
    x_2: float
    y_1: float
    y_2: float
    """S = dp/du [m/(N m)]."""
    x_11: float
    x_12: float
    x_22: float
    y_11: float
    y_12: float
    y_22: float
    """Curvature of p [m/(N m)^2]."""


class Places(NamedTuple):
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
    """Whether the angles are linear in u, as in the paper, "Quasi-Static Feedforward Control": without gravity."""
    return statics.starts.size == 0


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
    between_starts(statics, u1, u2, theta)
    equilibrium(statics.body, u1, u2, scratch)


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
        x += statics.L[i] * c
        y += statics.L[i] * s
    return x, y


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
def expand_tip(statics: Statics, u1: float, u2: float, scratch: Scratch) -> Expansion:
    """Tip, sensitivity and curvature of the static map at u [N m].

    Tip and S: paper, "Quasi-Static Feedforward Control". Curvature is not in the paper: `newton_point` needs it.
    In place: scratch.
    """
    static_pose(statics, u1, u2, scratch)
    theta, linear = scratch.theta, is_linear(statics)
    if not linear:
        slopes(statics, theta, scratch)
    x = y = x_1 = x_2 = y_1 = y_2 = 0.0
    x_11 = x_12 = x_22 = y_11 = y_12 = y_22 = 0.0
    for i in range(statics.L.size):
        c1, c2 = slope(statics, scratch, i)
        s, c = sine_cosine(theta[i])
        dx, dy = statics.L[i] * c, statics.L[i] * s
        x, y = x + dx, y + dy
        x_1, x_2 = x_1 - dy * c1, x_2 - dy * c2
        y_1, y_2 = y_1 + dx * c1, y_2 + dx * c2
        x_11, x_12, x_22 = x_11 - dx * c1 * c1, x_12 - dx * c1 * c2, x_22 - dx * c2 * c2
        y_11, y_12, y_22 = y_11 - dy * c1 * c1, y_12 - dy * c1 * c2, y_22 - dy * c2 * c2
    if not linear:
        curved = curvature_of_angles(statics, theta, scratch)
        x_11, x_12, x_22 = x_11 + curved[0], x_12 + curved[1], x_22 + curved[2]
        y_11, y_12, y_22 = y_11 + curved[3], y_12 + curved[4], y_22 + curved[5]
    return Expansion(x, y, x_1, x_2, y_1, y_2, x_11, x_12, x_22, y_11, y_12, y_22)


@kernel
def slopes(statics: Statics, theta: Array, scratch: Scratch) -> None:
    """K_theta^-1 T_theta at the pose theta (N,) [rad], K_theta with gravity's stiffness there.

    Paper, "Quasi-Static Feedforward Control", whose K_theta has the springs alone. In place: scratch.pivot, and
    scratch.x, which becomes the slopes by u1 and by u2 (2,N) [rad/(N m)].
    """
    body = statics.body
    factor(body, theta, scratch.pivot)
    for j in range(2):
        for i in range(theta.size):
            scratch.x[j, i] = body.T_theta[i, j]
        solve(body.k, scratch.pivot, scratch.x[j])


@kernel
def slope(statics: Statics, scratch: Scratch, i: int) -> Pair:
    """Of theta_i by u1 and by u2 [rad/(N m)]: where the map is linear everywhere the same, else what `slopes` found.

    Paper, "Quasi-Static Feedforward Control".
    """
    if is_linear(statics):
        return statics.compliance[i, 0], statics.compliance[i, 1]
    return scratch.x[0, i], scratch.x[1, i]


@kernel
def curvature_of_angles(
    statics: Statics, theta: Array, scratch: Scratch
) -> tuple[float, float, float, float, float, float]:
    """What the second derivatives of the angles by u add to those of the tip: x by 11, 12, 22, then y [m/(N m)^2].

    K theta_jk = -tau theta_j theta_k, tau the torque of gravity. After `slopes` at theta (N,), whose pivots and slopes
    it uses; K is symmetric, so two solutions K^-1 dp/dtheta serve all three. Not in the paper, which has no gravity.
    In place: scratch.trial.
    """
    body = statics.body
    reach = scratch.trial
    x_11 = x_12 = x_22 = y_11 = y_12 = y_22 = 0.0
    for axis in range(2):
        for i in range(theta.size):
            s, c = sine_cosine(theta[i])
            reach[i] = -statics.L[i] * s if axis == 0 else statics.L[i] * c
        solve(body.k, scratch.pivot, reach)
        d_11 = d_12 = d_22 = 0.0
        for i in range(theta.size):
            s, c = sine_cosine(theta[i])
            pull = reach[i] * (body.weight[1, i] * c - body.weight[0, i] * s)
            d_11 -= pull * scratch.x[0, i] * scratch.x[0, i]
            d_12 -= pull * scratch.x[0, i] * scratch.x[1, i]
            d_22 -= pull * scratch.x[1, i] * scratch.x[1, i]
        if axis == 0:
            x_11, x_12, x_22 = d_11, d_12, d_22
        else:
            y_11, y_12, y_22 = d_11, d_12, d_22
    return x_11, x_12, x_22, y_11, y_12, y_22


@kernel
def sensitivity(statics: Statics, theta: Array, scratch: Scratch) -> tuple[float, float, float, float]:
    """S = J(theta) K_theta^-1 T_theta [m/(N m)] at any pose theta (N,), by rows: S11, S12, S21, S22.

    Eq. S: paper, "Quasi-Static Feedforward Control". In place: scratch, where there is gravity.
    """
    if not is_linear(statics):
        slopes(statics, theta, scratch)
    S11 = S12 = S21 = S22 = 0.0
    for i in range(theta.size):
        c1, c2 = slope(statics, scratch, i)
        s, c = sine_cosine(theta[i])
        J_x, J_y = -statics.L[i] * s, statics.L[i] * c
        S11, S12 = S11 + J_x * c1, S12 + J_x * c2
        S21, S22 = S21 + J_y * c1, S22 + J_y * c2  # Eq. S
    return S11, S12, S21, S22


@kernel
def side_of(statics: Statics, u1: float, u2: float, scratch: Scratch) -> float:
    """Determinant of the static map's S at u [m^2/(N m)^2]: its sign tells on which side of a fold that pose is.

    Not in the paper, which leaves the folds of the inverse open. In place: scratch.
    """
    static_pose(statics, u1, u2, scratch)
    S11, S12, S21, S22 = sensitivity(statics, scratch.theta, scratch)
    return S11 * S22 - S12 * S21


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
