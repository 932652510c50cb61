"""A planar rod that bends, stretches and shears (Simo 1985, Reissner 1972), and one step of its motion in time.

Nothing here is shared with the chain of the controller's model: no rigid rods, no constraints. On a staggered grid of n
elements element i has the angle theta_i of its cross-section, and its free end the position r_i; r_{-1} is the clamp.
With t, n the section's axis and normal and d = r_i - r_{i-1}, an element is strained by

    stretch  e = t.d / l - 1,    shear  g = n.d / l,    bend of section i  theta_i - theta_{i-1}.

The step is the energy-conserving one of Simo, Tarnow and Doblare 1995: with Delta the way of the step, velocities are
Delta / h, stresses the mean of both ends', and forces these times exact differences of the strains (a discrete
gradient). So without damping the energy is kept to the last digits, and with it the energy falls, for every step and
stiffness. Newton's iteration on 3x3 blocks, order 2, O(n).
"""

from typing import NamedTuple

import numpy as np

from controller.arrays import Array, Pair
from controller.kernels.compiled import flushed, inlined, kernel
from controller.kernels.group import Group
from controller.kernels.model.rod import sine_cosine

CONVERGED = 1e-7
"""Correction of angles [rad] and of positions [element lengths] after which Newton's next one is a rounding error."""
ITERATIONS = 12
"""Most of them in a step; two are usual."""


class CosseratRod(Group):
    """A clamped rod of n equal elements, base first. SI units."""

    l: float  # noqa: E741
    """Length of an element [m]."""
    m: Array
    """Mass at the free end of each element (n,) [kg]."""
    I: Array  # noqa: E741
    """Moment of inertia of each cross-section's element (n,) [kg m^2]."""
    EA: float
    """Stiffness to stretch [N]."""
    GA: float
    """Stiffness to shear [N]."""
    k: Array
    """Stiffness of the bend before element i, without pressure (n,) [N m/rad]."""
    bend: Array
    """Bend before element i that carries no moment (n,) [rad]."""
    alpha: float
    """Damping by mass [1/s]."""
    beta: float
    """Damping by stiffness, as of a Kelvin-Voigt material [s]."""
    g: Array
    """Gravity (2,) [m/s^2]."""


class RodForces(Group):
    """What acts on the rod in a step."""

    k: Array
    """Stiffness of the bends in force (n,) [N m/rad]."""
    moment: Array
    """Of the chambers, in each bend (n,) [N m]."""
    F: Array
    """Forces on the free ends of the elements (2,n) [N]."""
    longer: Array
    """Stretch of each element at which it carries no force (n,) [1]."""


class RodMotion(Group):
    """Where the rod is, and how it moves; rows x, y of the free ends, theta of the sections."""

    q: Array
    """(3,n) [m, m, rad]."""
    v: Array
    """(3,n) [m/s, m/s, rad/s]."""
    way: Array
    """Delta of the last step (3,n)."""


class Middle(NamedTuple):
    """An element in the middle of a step: what its torque, force and their slopes are made of."""

    c: float
    s: float
    """Its axis is t = (c, s), its normal n = (-s, c)."""
    C: float
    S: float
    """Cosine and sine of half its turn."""
    sinc: float
    sinc_slope: float
    """sin(half)/half, and half its slope."""
    along: float
    across: float
    """t.d and n.d [m]."""
    moved: float
    slid: float
    """t and n times the way of d [m]."""


class Newton(Group):
    """Scratch of a step."""

    strain: Array
    """Stretch and shear at the begin of the step (n,2) [1]."""
    slope: Array
    """Slopes of an element's torque and force by its angle and by d (n,3,3)."""
    row: Array
    """A block row [diagonal, upper, right-hand side] (n,3,7)."""
    lower: Array
    """(3,3)."""


def make_newton(n: int) -> Newton:
    """Scratch for n elements."""
    return Newton(np.zeros((n, 2)), np.zeros((n, 3, 3)), np.zeros((n, 3, 7)), np.zeros((3, 3)))


@kernel
def rod_step(rod: CosseratRod, forces: RodForces, h: float, motion: RodMotion, newton: Newton) -> None:
    """Advance the rod by h [s]. Not in the paper: Simo, Tarnow and Doblare 1995. In place: motion, newton."""
    strains(rod, motion.q, newton.strain)
    for _ in range(ITERATIONS):
        balance(rod, forces, h, motion, newton)
        if correct(rod, newton, motion.way) < CONVERGED:
            break
    for i in range(rod.m.size):
        for j in range(3):
            motion.q[j, i] += motion.way[j, i]
            motion.v[j, i] = flushed(2.0 * motion.way[j, i] / h - motion.v[j, i])


@kernel
def strains(rod: CosseratRod, q: Array, out_strain: Array) -> None:
    """Stretch and shear (n,2) of the pose q (3,n). Not in the paper: Reissner 1972."""
    x = y = 0.0
    for i in range(rod.m.size):
        s, c = sine_cosine(q[2, i])
        d_x, d_y = q[0, i] - x, q[1, i] - y
        x, y = q[0, i], q[1, i]
        out_strain[i, 0] = (c * d_x + s * d_y) / rod.l - 1.0
        out_strain[i, 1] = (c * d_y - s * d_x) / rod.l


@kernel
def balance(rod: CosseratRod, forces: RodForces, h: float, motion: RodMotion, newton: Newton) -> None:
    """Equations of the step at the present guess of its way: block rows, and what they are out of balance.

    Not in the paper: Simo, Tarnow and Doblare 1995. In place: newton.
    """
    n = rod.m.size
    for i in range(n):
        inertia(rod, forces, h, i, motion, newton.row[i])
    for i in range(n):
        resist_element(rod, forces, h, i, motion, newton)
        resist_bend(rod, forces, h, i, motion, newton.row)
    for i in range(n):
        link(rod, i, newton)


@inlined
def inertia(rod: CosseratRod, forces: RodForces, h: float, i: int, motion: RodMotion, out_row: Array) -> None:
    """Mass, damping by mass, gravity and F of element i, alone in its block row (3,7): theta, x, y.

    Not in the paper, whose rods are rigid.
    """
    rate, scale = 2.0 / h, 2.0 / (h * h) + rod.alpha / h
    for a in range(3):
        for b in range(7):
            out_row[a, b] = 0.0
    out_row[0, 0] = rod.I[i] * scale
    out_row[0, 6] = rod.I[i] * (rate * motion.v[2, i] - scale * motion.way[2, i])
    for a in range(2):
        out_row[a + 1, a + 1] = rod.m[i] * scale
        push = rate * motion.v[a, i] - scale * motion.way[a, i] + rod.g[a]
        out_row[a + 1, 6] = rod.m[i] * push + forces.F[a, i]


@kernel
def resist_element(rod: CosseratRod, forces: RodForces, h: float, i: int, motion: RodMotion, newton: Newton) -> None:
    """Torque and force of the stretched and sheared element i in the right-hand sides, and their slopes.

    N and V are the mean stresses of the step, and damping. Not in the paper: Simo, Tarnow and Doblare 1995.
    In place: newton.
    """
    at = middle_of(motion.q, motion.way, i)
    later = 0.5 + rod.beta / h
    e = newton.strain[i, 0] - forces.longer[i]
    N = rod.EA * (e + later * (at.C * at.moved + 2.0 * at.S * at.across) / rod.l)
    V = rod.GA * (newton.strain[i, 1] + later * (at.C * at.slid - 2.0 * at.S * at.along) / rod.l)
    push_element(at, N, V, i, newton.row)
    slope_element(at, N, V, (rod.EA * later / rod.l, rod.GA * later / rod.l), newton.slope[i])


@inlined
def middle_of(q: Array, way: Array, i: int) -> Middle:
    """Element i in the middle of the step that goes `way` (3,n) from the pose q (3,n).

    Not in the paper: Simo, Tarnow and Doblare 1995.
    """
    half = 0.5 * way[2, i]
    s, c = sine_cosine(q[2, i] + half)
    S, C = sine_cosine(half)
    sinc, sinc_slope = sinc_of(half)
    w_x, w_y = way[0, i], way[1, i]
    d_x, d_y = q[0, i] + 0.5 * w_x, q[1, i] + 0.5 * w_y
    if i > 0:
        w_x, w_y = w_x - way[0, i - 1], w_y - way[1, i - 1]
        d_x, d_y = d_x - q[0, i - 1] - 0.5 * way[0, i - 1], d_y - q[1, i - 1] - 0.5 * way[1, i - 1]
    along, across = c * d_x + s * d_y, c * d_y - s * d_x
    moved, slid = c * w_x + s * w_y, c * w_y - s * w_x
    return Middle(c, s, C, S, sinc, sinc_slope, along, across, moved, slid)


@inlined
def push_element(at: Middle, N: float, V: float, i: int, row: Array) -> None:
    """Take force cos(half) (N t + V n) and torque sinc(half) (N n.d - V t.d) of element i off the right-hand sides.

    They are exact differences of the energy. Not in the paper: Simo, Tarnow and Doblare 1995. In place: row (n,3,7).
    """
    f_x, f_y = at.C * (at.c * N - at.s * V), at.C * (at.s * N + at.c * V)
    row[i, 0, 6] -= at.sinc * (N * at.across - V * at.along)
    row[i, 1, 6] -= f_x
    row[i, 2, 6] -= f_y
    if i > 0:
        row[i - 1, 1, 6] += f_x
        row[i - 1, 2, 6] += f_y


@inlined
def slope_element(at: Middle, N: float, V: float, stiff: Pair, out_slope: Array) -> None:
    """Slopes (3,3) of torque and force by the element's angle and by d; `stiff`: of N and V by their strains.

    Not in the paper: Simo, Tarnow and Doblare 1995.
    """
    c, s, C, S, sinc, sinc_slope, along, across, moved, slid = at
    n_l, v_l = stiff
    end_along, end_across = along + 0.5 * moved, across + 0.5 * slid
    N_turn = n_l * (C * end_across - S * end_along)
    V_turn = -v_l * (C * end_along + S * end_across)
    turn = N_turn * across - V_turn * along - 0.5 * (N * along + V * across)
    out_slope[0, 0] = sinc_slope * (N * across - V * along) + sinc * turn
    m_t = sinc * (n_l * C * across + v_l * S * along - 0.5 * V)
    m_n = sinc * (n_l * S * across - v_l * C * along + 0.5 * N)
    out_slope[0, 1], out_slope[0, 2] = c * m_t - s * m_n, s * m_t + c * m_n
    t_turn = C * N_turn - 0.5 * (C * V + S * N)
    n_turn = C * V_turn + 0.5 * (C * N - S * V)
    out_slope[1, 0], out_slope[2, 0] = c * t_turn - s * n_turn, s * t_turn + c * n_turn
    a, b, a2, b2 = C * n_l * C, C * n_l * S, -C * v_l * S, C * v_l * C
    out_slope[1, 1] = c * (a * c - b * s) - s * (a2 * c - b2 * s)
    out_slope[1, 2] = c * (a * s + b * c) - s * (a2 * s + b2 * c)
    out_slope[2, 1] = s * (a * c - b * s) + c * (a2 * c - b2 * s)
    out_slope[2, 2] = s * (a * s + b * c) + c * (a2 * s + b2 * c)


@inlined
def sinc_of(x: float) -> Pair:
    """sin(x)/x and half its slope, of half a step's turn: a series, exact to 1e-16 for |x| < 0.3.

    Not in the paper: 0/0 at rest.
    """
    z = x * x
    value = 1.0 - z / 6.0 * (1.0 - z / 20.0 * (1.0 - z / 42.0 * (1.0 - z / 72.0 * (1.0 - z / 110.0))))
    slope = -x / 6.0 * (1.0 - z / 10.0 * (1.0 - z / 28.0 * (1.0 - z / 54.0 * (1.0 - z / 88.0))))
    return value, slope


@inlined
def resist_bend(rod: CosseratRod, forces: RodForces, h: float, i: int, motion: RodMotion, row: Array) -> None:
    """Moment in the bend before element i on the sections at both of its ends.

    Not in the paper: Reissner 1972. In place: row (n,3,7).
    """
    bend, way = motion.q[2, i] - rod.bend[i], motion.way[2, i]
    if i > 0:
        bend, way = bend - motion.q[2, i - 1], way - motion.way[2, i - 1]
    later = 0.5 + rod.beta / h
    moment, slope = forces.k[i] * (bend + later * way) - forces.moment[i], forces.k[i] * later
    row[i, 0, 0] += slope
    row[i, 0, 6] -= moment
    if i > 0:
        row[i - 1, 0, 0] += slope
        row[i - 1, 0, 6] += moment
        row[i - 1, 0, 3] = -slope


@kernel
def link(rod: CosseratRod, i: int, newton: Newton) -> None:
    """Put the slopes of element i where they belong, and eliminate the unknowns of element i - 1 from its row.

    Not in the paper: block elimination. In place: newton.
    """
    row, slope, lower = newton.row[i], newton.slope[i], newton.lower
    for a in range(3):
        for b in range(3):
            row[a, b] += slope[a, b]
    if i > 0:
        before = newton.row[i - 1]
        for a in range(3):
            lower[a, 0] = 0.0
            for b in range(1, 3):
                lower[a, b] = -slope[a, b]
        lower[0, 0] = before[0, 3]
        for a in range(1, 3):
            for b in range(3):
                before[a, b + 3] = -slope[a, b]
            for b in range(1, 3):
                before[a, b] += slope[a, b]
        reduce(before)
        for a in range(3):
            for b in range(3):
                for k in range(3):
                    row[a, b] -= lower[a, k] * before[k, b + 3]
                row[a, 6] -= lower[a, b] * before[b, 6]
    if i == rod.m.size - 1:
        reduce(row)


@inlined
def reduce(row: Array) -> None:
    """Gauss and Jordan on a block row (3,7), without exchange of rows: inertia is on the diagonal.

    Not in the paper: block elimination. In place: row.
    """
    for k in range(3):
        scale = 1.0 / row[k, k]
        for b in range(k + 1, 7):
            row[k, b] *= scale
        for a in range(3):
            if a != k:
                factor = row[a, k]
                for b in range(k + 1, 7):
                    row[a, b] -= factor * row[k, b]


@kernel
def correct(rod: CosseratRod, newton: Newton, way: Array) -> float:
    """Add Newton's correction to the way (3,n); its largest part [rad, element lengths].

    Not in the paper: block elimination. In place: newton, way.
    """
    largest = 0.0
    row = newton.row
    for n in range(rod.m.size):
        i = rod.m.size - 1 - n
        if n > 0:
            for a in range(3):
                for b in range(3):
                    row[i, a, 6] -= row[i, a, b + 3] * row[i + 1, b, 6]
        way[2, i] += row[i, 0, 6]
        way[0, i] += row[i, 1, 6]
        way[1, i] += row[i, 2, 6]
        moved = max(abs(row[i, 1, 6]), abs(row[i, 2, 6])) / rod.l
        largest = max(largest, max(moved, abs(row[i, 0, 6])))
    return largest
