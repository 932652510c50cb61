"""The static equilibrium of the chain under torques, springs and gravity: Newton's iteration, O(N) by elimination.

In the angles the potential energy is E = 1/2 sum k_i (theta_i - theta_i-1 - bend_i)^2 - sum (T_theta u)_i theta_i
- sum (g_x w_i cos theta_i + g_y w_i sin theta_i): each rod carries what hangs on it, w_i [kg m]. Its slope is the
imbalance of the torques, its curvature K is tridiagonal. Gravity is not in the paper, whose plane is horizontal.
"""

from typing import NamedTuple

import numpy as np

from controller.arrays import Array, Pair
from controller.kernels.compiled import kernel
from controller.kernels.group import Group
from controller.kernels.model.rod import sine_cosine, under_levels

ITERATIONS, HALVINGS = 60, 12
STEP_MAX = 0.5
"""Longest step of an iteration [rad]: beyond it E is far from a parabola."""
DONE = 1e-8
"""After a step below this nothing is left but rounding: Newton's error is of the order of its square [rad]."""
SETTLED = 1e-12
"""The same where it begins near, and nothing else is asked [rad]."""
FINE = 1e-4
"""A step below this is in the basin: E need not be asked, and rounding soon hides whether it falls [rad]."""
STAGES = 4
"""Torques that go from one point of a grid to the next go in this many stages."""
SOFTEST = 1e-9
"""Least pivot, as a share of the springs' own stiffness there: below it the pose is not stable."""


class Body(NamedTuple):
    """What of a chain of N rods, base first, decides its statics."""

    k: Array
    """Stiffness of hinge i (N,) [N m/rad]."""
    bend: Array
    """Bend of hinge i at which its spring carries nothing (N,) [rad]."""
    T_theta: Array
    """Torque map (N,2) [1]."""
    weight: Array
    """Torque on theta_i of gravity along x and along y where the rod stands across it (2,N) [N m]."""
    stiffening: Array
    """Share of k that |u1| and |u2| add to it (N,2) [1/(N m)]; (0,2) where pressure does not stiffen."""
    stretching: Array
    """Share of a rod's length that they add to it, by which gravity's torque grows (N,2) [1/(N m)]; (0,2) for none."""


class Scratch(Group):
    """Of one caller: two threads never share one."""

    theta: Array
    """Angles (N,) [rad]."""
    pivot: Array
    """Pivots of K, eliminated from the base (N,) [N m/rad]."""
    x: Array
    """Right-hand sides, solved in place (2,N)."""
    trial: Array
    """Angles that a step leads to (N,) [rad]."""
    k: Array
    """Stiffness under pressure (N,) [N m/rad]."""
    weight: Array
    """Torque of gravity under pressure (2,N) [N m]."""


def make_scratch(rods: int) -> Scratch:
    """Scratch of one caller for chains of `rods`."""
    (theta, pivot, trial, k), (x, weight) = np.zeros((4, rods)), np.zeros((2, 2, rods))
    return Scratch(theta, pivot, x, trial, k, weight)


@kernel
def under_pressure(body: Body, u1: float, u2: float, scratch: Scratch) -> Body:
    """The body as stiff and as long as the pressures of u [N m] make it: itself where they make nothing of it.

    k_i = k_i(0) (1 + sum_j stiffening_ij |u_j|), and L_i likewise. Not in the paper, where no pressure changes either.
    In place: scratch.k, scratch.weight.
    """
    stiffens, stretches = body.stiffening.shape[0] > 0, body.stretching.shape[0] > 0
    if not stiffens and not stretches:
        return body
    if stiffens:
        under_levels(body.k, body.stiffening, abs(u1), abs(u2), scratch.k)
    if stretches:
        for axis in range(2):
            under_levels(body.weight[axis], body.stretching, abs(u1), abs(u2), scratch.weight[axis])
    return Body(
        scratch.k if stiffens else body.k,
        body.bend,
        body.T_theta,
        scratch.weight if stretches else body.weight,
        body.stiffening,
        body.stretching,
    )


@kernel
def equilibrium(body: Body, u1: float, u2: float, scratch: Scratch) -> None:
    """Angles where the torques cancel, from those in scratch.theta on.

    It ends in a minimum of E: what softens is left out of K where K is not positive definite, and no step raises E.
    Not in the paper, which has no gravity. In place: scratch.
    """
    theta, trial, x = scratch.theta, scratch.trial, scratch.x
    rods, body = theta.size, under_pressure(body, u1, u2, scratch)
    level = lower = energy(body, u1, u2, theta)
    for _ in range(ITERATIONS):
        imbalance(body, u1, u2, theta, x[0])
        factor(body, theta, scratch.pivot)
        solve(body.k, scratch.pivot, x[0])
        longest = 0.0
        for i in range(rods):
            longest = max(longest, abs(x[0, i]))
        share = min(1.0, STEP_MAX / longest) if longest > 0.0 else 0.0
        for _ in range(HALVINGS):
            for i in range(rods):
                trial[i] = theta[i] + share * x[0, i]
            if longest < FINE:
                break
            lower = energy(body, u1, u2, trial)
            if lower < level:
                break
            share *= 0.5
        else:
            break  # nothing is lower: rounding
        level = lower
        for i in range(rods):
            theta[i] = trial[i]
        if longest < DONE:
            break


@kernel
def lead_pose(body: Body, theta: Array, begin: Pair, end: Pair, scratch: Scratch) -> None:
    """Where the pose theta (N,) [rad] at torques `begin` gets as they go to `end` [N m], in scratch.theta.

    In STAGES, so that each begins near the pose that it leads to. Not in the paper, which has no gravity.
    In place: scratch.
    """
    for i in range(theta.size):
        scratch.theta[i] = theta[i]
    for stage in range(1, STAGES + 1):
        share = stage / STAGES
        equilibrium(body, begin[0] + share * (end[0] - begin[0]), begin[1] + share * (end[1] - begin[1]), scratch)


@kernel
def settle(body: Body, theta: Array, pivot: Array, step: Array) -> bool:
    """Newton's iteration without torques from theta (N,) on; False where K is not positive definite, or it wanders.

    It looks at no energy, so it stays on its branch or fails: see `equilibrium` for a minimum wherever it begins.
    Not in the paper, which has no gravity. In place: theta, pivot, step (N,).
    """
    for _ in range(ITERATIONS):
        imbalance(body, 0.0, 0.0, theta, step)
        if not factor(body, theta, pivot):
            return False
        solve(body.k, pivot, step)
        longest = 0.0
        for i in range(theta.size):
            longest = max(longest, abs(step[i]))
        share = 1.0 / max(1.0, longest)
        for i in range(theta.size):
            theta[i] += share * step[i]
        if longest < SETTLED:
            return True
    return False


@kernel
def out_of_balance(body: Body, u1: float, u2: float, scratch: Scratch) -> float:
    """Largest torque out of balance [N m] in the pose scratch.theta.

    Not in the paper, which has no gravity. In place: scratch.x, scratch.k.
    """
    imbalance(under_pressure(body, u1, u2, scratch), u1, u2, scratch.theta, scratch.x[0])
    worst = 0.0
    for i in range(scratch.theta.size):
        worst = max(worst, abs(scratch.x[0, i]))
    return worst


@kernel
def energy(body: Body, u1: float, u2: float, theta: Array) -> float:
    """Potential energy [J] of the pose theta (N,), but for a constant. Gravity is not in the paper."""
    total = before = 0.0
    for i in range(theta.size):
        s, c = sine_cosine(theta[i])
        turn = theta[i] - before - body.bend[i]
        total += 0.5 * body.k[i] * turn * turn - body.weight[0, i] * c - body.weight[1, i] * s
        total -= (body.T_theta[i, 0] * u1 + body.T_theta[i, 1] * u2) * theta[i]
        before = theta[i]
    return total


@kernel
def imbalance(body: Body, u1: float, u2: float, theta: Array, out_torque: Array) -> None:
    """Torque on each angle (N,) [N m] of u, springs and gravity: minus the slope of E. Gravity is not in the paper."""
    before = 0.0
    for i in range(theta.size):
        s, c = sine_cosine(theta[i])
        spring = body.k[i] * (theta[i] - before - body.bend[i])
        out_torque[i] = body.T_theta[i, 0] * u1 + body.T_theta[i, 1] * u2 - spring
        out_torque[i] += body.weight[1, i] * c - body.weight[0, i] * s
        if i > 0:
            out_torque[i - 1] += spring
        before = theta[i]


@kernel
def factor(body: Body, theta: Array, out_pivot: Array) -> bool:
    """Pivots (N,) of K at theta (N,), and whether it is positive definite; else those without what softens it.

    Not in the paper, which has no gravity.
    """
    if eliminate_stiffness(body, theta, True, out_pivot):
        return True
    eliminate_stiffness(body, theta, False, out_pivot)
    return False


@kernel
def eliminate_stiffness(body: Body, theta: Array, softened: bool, out_pivot: Array) -> bool:
    """One pass of `factor` from the base to the tip; False at the first pivot that is too small.

    Not in the paper, which has no gravity.
    """
    rods = theta.size
    for i in range(rods):
        s, c = sine_cosine(theta[i])
        beyond = body.k[i + 1] if i + 1 < rods else 0.0
        stiffness = body.k[i] + beyond
        gravity = body.weight[0, i] * c + body.weight[1, i] * s
        pivot = stiffness + (gravity if softened else max(0.0, gravity))
        if i > 0:
            pivot -= body.k[i] * body.k[i] / out_pivot[i - 1]
        out_pivot[i] = pivot
        if not pivot > SOFTEST * stiffness:
            return False
    return True


@kernel
def solve(k: Array, pivot: Array, x: Array) -> None:
    """K^-1 x by the pivots (N,) of K, whose off-diagonal entries are -k.

    K_theta^-1: paper, "Quasi-Static Feedforward Control". In place: x (N,).
    """
    rods = x.size
    for i in range(1, rods):
        x[i] += k[i] / pivot[i - 1] * x[i - 1]
    x[rods - 1] /= pivot[rods - 1]
    for i in range(rods - 2, -1, -1):
        x[i] = (x[i] + k[i + 1] * x[i + 1]) / pivot[i]
