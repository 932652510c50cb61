"""How the static map goes on: its slope S and its curvature.

Paper, "Quasi-Static Feedforward Control": S = J K_theta^-1 T_theta. Gravity makes K_theta depend on the pose, and the
pressures that stiffen the hinges on u; neither is in the paper.
"""

from typing import NamedTuple

from controller.arrays import Array, Pair
from controller.kernels.compiled import inlined, kernel
from controller.kernels.model.equilibrium import Body, Scratch, factor, solve, under_pressure
from controller.kernels.model.rod import sine_cosine
from controller.kernels.model.statics import Statics, is_linear, length_of, static_pose


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


@kernel
def expand_tip(statics: Statics, u1: float, u2: float, scratch: Scratch) -> Expansion:
    """Tip, sensitivity and curvature of the static map at u [N m].

    Tip and S: paper, "Quasi-Static Feedforward Control". Curvature is not in the paper: `newton_point` needs it.
    In place: scratch.
    """
    static_pose(statics, u1, u2, scratch)
    theta, linear = scratch.theta, is_linear(statics)
    if not linear:
        slopes(statics, theta, u1, u2, scratch)
    x = y = x_1 = x_2 = y_1 = y_2 = 0.0
    x_11 = x_12 = x_22 = y_11 = y_12 = y_22 = 0.0
    for i in range(statics.L.size):
        c1, c2 = slope(statics, scratch, i)
        s, c = sine_cosine(theta[i])
        L = length_of(statics, i, abs(u1), abs(u2))
        l1, l2 = lengthening(statics, i, u1, u2)
        dx, dy = L * c, L * s
        x, y = x + dx, y + dy
        x_1, x_2 = x_1 - dy * c1 + l1 * c, x_2 - dy * c2 + l2 * c
        y_1, y_2 = y_1 + dx * c1 + l1 * s, y_2 + dx * c2 + l2 * s
        x_11, x_22 = x_11 - dx * c1 * c1 - 2.0 * l1 * s * c1, x_22 - dx * c2 * c2 - 2.0 * l2 * s * c2
        y_11, y_22 = y_11 - dy * c1 * c1 + 2.0 * l1 * c * c1, y_22 - dy * c2 * c2 + 2.0 * l2 * c * c2
        mixed = l1 * c2 + l2 * c1
        x_12, y_12 = x_12 - dx * c1 * c2 - mixed * s, y_12 - dy * c1 * c2 + mixed * c
    if not linear:
        curved = curvature_of_angles(statics, theta, (u1, u2), scratch)
        x_11, x_12, x_22 = x_11 + curved[0], x_12 + curved[1], x_22 + curved[2]
        y_11, y_12, y_22 = y_11 + curved[3], y_12 + curved[4], y_22 + curved[5]
    return Expansion(x, y, x_1, x_2, y_1, y_2, x_11, x_12, x_22, y_11, y_12, y_22)


@inlined
def lengthening(statics: Statics, i: int, u1: float, u2: float) -> Pair:
    """Slopes of the length of rod i by u1 and by u2 [m/(N m)]. Not in the paper: see `length_of`."""
    share = statics.body.stretching
    if share.shape[0] == 0:
        return 0.0, 0.0
    return statics.L[i] * share[i, 0] * sign_of(u1), statics.L[i] * share[i, 1] * sign_of(u2)


@kernel
def slopes(statics: Statics, theta: Array, u1: float, u2: float, scratch: Scratch) -> None:
    """K_theta^-1 (T_theta - dK/du bend + dG/du) at the pose theta (N,) [rad] and u [N m]; G is gravity's torque.

    Its stiffness is in K_theta. Paper, "Quasi-Static Feedforward Control", whose K_theta has the springs alone, and
    depends on nothing.
    In place: scratch.pivot, scratch.k, scratch.weight, and scratch.x, which becomes both slopes (2,N) [rad/(N m)].
    """
    body = under_pressure(statics.body, u1, u2, scratch)
    factor(body, theta, scratch.pivot)
    for j in range(2):
        for i in range(theta.size):
            scratch.x[j, i] = body.T_theta[i, j]
        sign = sign_of(u1) if j == 0 else sign_of(u2)
        if body.stiffening.shape[0] > 0:
            resist(statics.body, j, sign, theta, True, scratch.x[j])
        if body.stretching.shape[0] > 0:
            weigh(statics.body, j, sign, theta, scratch.x[j])
        solve(body.k, scratch.pivot, scratch.x[j])


@kernel
def sign_of(u: float) -> float:
    """Slope of |u|, 0 where it has none. Not in the paper: of the stiffness under pressure."""
    return 1.0 if u > 0.0 else (-1.0 if u < 0.0 else 0.0)


@kernel
def resist(body: Body, j: int, stiffer: float, theta: Array, at_rest: bool, torque: Array) -> None:
    """Take off what the hinges resist more per u_j, whose slope of |u_j| is `stiffer`, in the pose theta (N,) [rad].

    With `at_rest` their bends at rest do not count, else theta is a difference of poses. Not in the paper: see
    `under_pressure`. In place: torque (N,) [1].
    """
    before = 0.0
    for i in range(theta.size):
        bend = theta[i] - before - (body.bend[i] if at_rest else 0.0)
        before = theta[i]
        more = stiffer * body.k[i] * body.stiffening[i, j] * bend
        torque[i] -= more
        if i > 0:
            torque[i - 1] += more


@kernel
def weigh(body: Body, j: int, longer: float, theta: Array, torque: Array) -> None:
    """Add what gravity turns the rods more per u_j, whose slope of |u_j| is `longer`, in the pose theta (N,) [rad].

    Not in the paper: see `under_pressure`. In place: torque (N,) [1].
    """
    for i in range(theta.size):
        s, c = sine_cosine(theta[i])
        torque[i] += longer * body.stretching[i, j] * (body.weight[1, i] * c - body.weight[0, i] * s)


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
    statics: Statics, theta: Array, u: Pair, scratch: Scratch
) -> tuple[float, float, float, float, float, float]:
    """What the second derivatives of the angles by u add to those of the tip: x by 11, 12, 22, then y [m/(N m)^2].

    K theta_jk = -tau theta_j theta_k - dK/du_j theta_k - dK/du_k theta_j, tau the torque of gravity, whose stiffness is
    in K. After `slopes` at theta (N,) and u (2,) [N m], whose pivots, stiffness and slopes it uses; K is symmetric, so
    two solutions K^-1 dp/dtheta serve all three. Not in the paper, which has no gravity. In place: scratch.trial.
    """
    body, signs = statics.body, (sign_of(u[0]), sign_of(u[1]))
    reach, x = scratch.trial, scratch.x
    stiffens, stretches = body.stiffening.shape[0] > 0, body.stretching.shape[0] > 0
    k = scratch.k if stiffens else body.k
    weight = scratch.weight if stretches else body.weight
    x_11 = x_12 = x_22 = y_11 = y_12 = y_22 = 0.0
    for axis in range(2):
        for i in range(theta.size):
            s, c = sine_cosine(theta[i])
            L = length_of(statics, i, abs(u[0]), abs(u[1]))
            reach[i] = -L * s if axis == 0 else L * c
        solve(k, scratch.pivot, reach)
        d_11 = d_12 = d_22 = 0.0
        for i in range(theta.size):
            s, c = sine_cosine(theta[i])
            pull = reach[i] * (weight[1, i] * c - weight[0, i] * s)
            d_11, d_12 = d_11 - pull * x[0, i] * x[0, i], d_12 - pull * x[0, i] * x[1, i]
            d_22 -= pull * x[1, i] * x[1, i]
        if stiffens:
            more_11, more_12, more_22 = resisted(body, reach, x, signs)
            d_11, d_12, d_22 = d_11 - more_11, d_12 - more_12, d_22 - more_22
        if stretches:
            more_11, more_12, more_22 = hung_stiffer(body, theta, reach, x, signs)
            d_11, d_12, d_22 = d_11 - more_11, d_12 - more_12, d_22 - more_22
        if axis == 0:
            x_11, x_12, x_22 = d_11, d_12, d_22
        else:
            y_11, y_12, y_22 = d_11, d_12, d_22
    return x_11, x_12, x_22, y_11, y_12, y_22


@kernel
def resisted(body: Body, reach: Array, x: Array, stiffer: Pair) -> tuple[float, float, float]:
    """What reach^T (dK/du_j theta_k + dK/du_k theta_j) is for jk = 11, 12, 22, with slopes x (2,N) of the angles.

    Not in the paper: see `curvature_of_angles`.
    """
    more_11 = more_12 = more_22 = before = before_1 = before_2 = 0.0
    for i in range(reach.size):
        turn, bend_1, bend_2 = reach[i] - before, x[0, i] - before_1, x[1, i] - before_2
        before, before_1, before_2 = reach[i], x[0, i], x[1, i]
        by_1 = turn * stiffer[0] * body.k[i] * body.stiffening[i, 0]
        by_2 = turn * stiffer[1] * body.k[i] * body.stiffening[i, 1]
        more_11 += 2.0 * by_1 * bend_1
        more_12 += by_1 * bend_2 + by_2 * bend_1
        more_22 += 2.0 * by_2 * bend_2
    return more_11, more_12, more_22


@kernel
def hung_stiffer(body: Body, theta: Array, reach: Array, x: Array, longer: Pair) -> tuple[float, float, float]:
    """The same of gravity's stiffness in the pose theta (N,), which the lengths of the rods raise.

    Not in the paper: see `curvature_of_angles`.
    """
    more_11 = more_12 = more_22 = 0.0
    for i in range(reach.size):
        s, c = sine_cosine(theta[i])
        hung = reach[i] * (body.weight[1, i] * s + body.weight[0, i] * c)
        by_1, by_2 = hung * longer[0] * body.stretching[i, 0], hung * longer[1] * body.stretching[i, 1]
        more_11 += 2.0 * by_1 * x[0, i]
        more_12 += by_1 * x[1, i] + by_2 * x[0, i]
        more_22 += 2.0 * by_2 * x[1, i]
    return more_11, more_12, more_22


@kernel
def sensitivity(
    statics: Statics, theta: Array, u1: float, u2: float, scratch: Scratch
) -> tuple[float, float, float, float]:
    """S = J(theta) K_theta^-1 T_theta [m/(N m)] at any pose theta (N,), by rows: S11, S12, S21, S22.

    With the stiffness that u [N m] gives, where it gives any. Eq. S: paper, "Quasi-Static Feedforward Control".
    In place: scratch, where the map is not linear.
    """
    if not is_linear(statics):
        slopes(statics, theta, u1, u2, scratch)
    S11 = S12 = S21 = S22 = 0.0
    for i in range(theta.size):
        c1, c2 = slope(statics, scratch, i)
        s, c = sine_cosine(theta[i])
        L = length_of(statics, i, abs(u1), abs(u2))
        l1, l2 = lengthening(statics, i, u1, u2)
        S11, S12 = S11 - L * s * c1 + l1 * c, S12 - L * s * c2 + l2 * c
        S21, S22 = S21 + L * c * c1 + l1 * s, S22 + L * c * c2 + l2 * s  # Eq. S
    return S11, S12, S21, S22


@kernel
def side_of(statics: Statics, u1: float, u2: float, scratch: Scratch) -> float:
    """Determinant of the static map's S at u [m^2/(N m)^2]: its sign tells on which side of a fold that pose is.

    Not in the paper, which leaves the folds of the inverse open. In place: scratch.
    """
    static_pose(statics, u1, u2, scratch)
    S11, S12, S21, S22 = sensitivity(statics, scratch.theta, u1, u2, scratch)
    return S11 * S22 - S12 * S21
