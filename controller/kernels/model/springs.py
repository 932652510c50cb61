"""The observer's virtual springs and dampers: from points of the chain to where those were measured (Eq. OBS).

Each pulls at the very point at which its residual is taken, so it is the slope of an energy: with the hinges' springs
it makes a symmetric stiffness, and no gain can make it flutter. The paper's force enters the centre of the last rod,
which is the same in the limit of many rods. The integrators count it as part of the chain: a force that is held for a
step comes half a step late, which is a damping of -K_o dt/2.
"""

import numpy as np

from controller.arrays import Array, Pair, Words
from controller.kernels.compiled import inlined
from controller.kernels.group import Group

Pull = tuple[float, float, float]
"""Force along x and y [N], and torque about the rod's centre [N m]."""


class Springs(Group):
    """Those that pull come first, base to tip."""

    K: Array
    """K_o along x and y (2,) [N/m]."""
    B: Array
    """B_o along x and y (2,) [N s/m]."""
    active: Words
    """(1,) how many pull."""
    rod: Words
    """The rods that hold their points (n,)."""
    offset: Array
    """From the rod's centre to its point, towards the tip (n,) [m]."""
    anchor: Array
    """Where the points were measured, carried on to the step's middle (n,2) [m]."""
    rate: Array
    """Their measured velocity (n,2) [m/s]."""


class Points(Group):
    """Scratch of the implicit step: where the springs pull, and what they gave."""

    before: Array
    """The points at the start of the step (n,2) [m]."""
    at: Array
    """The points where its present stage begins (n,2) [m]."""
    power: Array
    """(1,) mean of what the springs gave in the last step [W]."""


def make_springs(count: int = 0) -> Springs:
    """None that pull, and room for `count`."""
    none, rods, anchor, rate = np.zeros(1, np.int64), np.zeros(count, np.int64), *np.zeros((2, count, 2))
    return Springs(np.zeros(2), np.zeros(2), none, rods, np.zeros(count), anchor, rate)


def make_points(count: int) -> Points:
    """Scratch for up to `count` springs."""
    return Points(np.zeros((count, 2)), np.zeros((count, 2)), np.zeros(1))


@inlined
def pull_of(springs: Springs, j: int, arm: Array, q: Array, v: Array, a: Array) -> Pull:
    """What spring j does to its rod in the state q, v (3,N), whose `a` (2,N) are `rod.rotations`.

    Eq. OBS: paper, "Dynamic observer", K_o and B_o.
    """
    i = springs.rod[j]
    share = springs.offset[j] / arm[i]
    r_x, r_y = share * a[1, i], -share * a[0, i]
    e_x, e_y = springs.anchor[j, 0] - (q[0, i] + r_x), springs.anchor[j, 1] - (q[1, i] + r_y)
    slip_x = springs.rate[j, 0] - (v[0, i] - v[2, i] * r_y)
    slip_y = springs.rate[j, 1] - (v[1, i] + v[2, i] * r_x)
    f_x = springs.K[0] * e_x + springs.B[0] * slip_x  # Eq. OBS
    f_y = springs.K[1] * e_y + springs.B[1] * slip_y  # Eq. OBS
    return f_x, f_y, r_x * f_y - r_y * f_x


@inlined
def spring_power(springs: Springs, arm: Array, q: Array, v: Array, a: Array) -> float:
    """What all of them give to the chain [W]: p_N'^T Q_obs, the third term of Eq. HDOT."""
    P = 0.0
    for j in range(springs.active[0]):
        i = springs.rod[j]
        f_x, f_y, torque = pull_of(springs, j, arm, q, v, a)
        P += f_x * v[0, i] + f_y * v[1, i] + torque * v[2, i]
    return P


@inlined
def begin_step(springs: Springs, arm: Array, q: Array, a: Array, out_points: Points) -> None:
    """Note where the points are in the pose q (3,N), whose `a` (2,N) are `rod.rotations`.

    p_model of Eq. OBS: paper, "Dynamic observer".
    """
    for j in range(springs.active[0]):
        i = springs.rod[j]
        share = springs.offset[j] / arm[i]
        out_points.before[j, 0] = out_points.at[j, 0] = q[0, i] + share * a[1, i]
        out_points.before[j, 1] = out_points.at[j, 1] = q[1, i] - share * a[0, i]


@inlined
def point_velocity(springs: Springs, j: int, arm: Array, v: Array, a: Array) -> Pair:
    """How fast v (3,N) moves the point of spring j [m/s]. Not in the paper: part of `implicit_step`."""
    i = springs.rod[j]
    turn = springs.offset[j] / arm[i] * v[2, i]
    return v[0, i] + turn * a[0, i], v[1, i] + turn * a[1, i]


@inlined
def go_on(springs: Springs, arm: Array, h: float, v: Array, a: Array, points: Points) -> None:
    """Move the points by what v (3,N) moves them in h [s]. Not in the paper: part of `implicit_step`.

    In place: points.at.
    """
    for j in range(springs.active[0]):
        x_dot, y_dot = point_velocity(springs, j, arm, v, a)
        points.at[j, 0] += h * x_dot
        points.at[j, 1] += h * y_dot


@inlined
def end_step(springs: Springs, arm: Array, dt: float, v: Array, a: Array, points: Points) -> None:
    """Book what they gave in a step of dt [s] whose mean velocity is v (3,N): p_N'^T Q_obs, third term of Eq. HDOT.

    In place: points.power.
    """
    P = 0.0
    for j in range(springs.active[0]):
        x_dot, y_dot = point_velocity(springs, j, arm, v, a)
        e_x = springs.anchor[j, 0] - points.before[j, 0] - 0.5 * dt * x_dot
        e_y = springs.anchor[j, 1] - points.before[j, 1] - 0.5 * dt * y_dot
        P += x_dot * (springs.K[0] * e_x + springs.B[0] * (springs.rate[j, 0] - x_dot))
        P += y_dot * (springs.K[1] * e_y + springs.B[1] * (springs.rate[j, 1] - y_dot))
    points.power[0] = P
