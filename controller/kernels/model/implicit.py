"""A linearly implicit step of the rod chain: any stiffness and damping at 1 ms, in O(N), without iteration.

In maximal coordinates mass, stiffness and damping are constant; only the directions of the hinges, A(q), turn. A step
freezes them where its middle will be, theta* = theta + dt/2 omega. What is left is linear and dissipative,
  M v' = Q - K q - D (theta - theta*) - B v + A*^T lambda,   A* v = 0,   theta' = omega,
with the observer's springs and dampers in K and B, and in the diagonal D what a force does by turning with the hinges:
rods hang on what pulls at them, be it weight, a load or a spring. That is advanced by the L-stable SDIRK method of
order 2: two stages, one factorisation, high modes die at once. The velocity goes from one step's directions into the
next's by a reflection through those between the two steps, which turns it without changing its kinetic energy, as the
true motion does. x and y follow from the angles, so the hinges never open. The energy law then holds for every dt, N,
stiffness and pose; see `implicit_step`.
"""

import math

import numpy as np

from controller.arrays import Array
from controller.kernels.compiled import flushed, inlined, kernel
from controller.kernels.group import Group
from controller.kernels.model.block import Block, factorise, make_block, solve_blocks
from controller.kernels.model.energy import (
    BAUMGARTE,
    DAMPING,
    OBSERVER,
    PNEUMATIC,
    Ledger,
    damping_power,
    load_power,
    pneumatic_power,
    stored_energy,
)
from controller.kernels.model.rod import Load, RodModel, RodState, apply_hinges, eliminate, rotations, substitute
from controller.kernels.model.springs import Points, Springs, begin_step, end_step, go_on, make_points

GAMMA = 1.0 - math.sqrt(0.5)
"""The SDIRK method's diagonal: with it, two stages are of order 2 and L-stable."""


class ImplicitWork(Group):
    """Scratch of one implicit step."""

    theta: Array
    """Angles at the middle of the step (N,) [rad]."""
    a: Array
    """a_i (2,N): at the start, then frozen at the middle, at last at the end [m]."""
    v: Array
    """Velocity at the first stage, at last the mean velocity of the step (3,N); the ledger reads it."""
    block: Block
    lam: Array
    """Impulses of the hinges in a projection (2,N+1) [N s]; the last column, beyond the free end, stays zero."""
    G: Array
    """Factors of the projection, see `rod.fold` (4,N)."""
    r: Array
    """Right-hand side of the projection (2,N) [m/s]."""
    points: Points
    """Of the observer's springs."""
    hang: Array
    """D: stiffness with which what pulls at each rod holds its direction (N,) [N m/rad]; 0 where it topples the rod."""
    lift: Array
    """(1,) gravity's work on the way from the frozen motion to closed hinges in the last step, and what `hang` holds
    at its end more than at its beginning [J]."""


def make_implicit_work(rods: int, springs: int = 0) -> ImplicitWork:
    """Scratch arrays for a chain of `rods` whose load has room for `springs`."""
    a, v, G, r = (np.zeros((rows, rods)) for rows in (2, 3, 4, 2))
    (theta, hang), points, lift = np.zeros((2, rods)), make_points(springs), np.zeros(1)
    return ImplicitWork(theta, a, v, make_block(rods), np.zeros((2, rods + 1)), G, r, points, hang, lift)


@kernel
def implicit_step(model: RodModel, load: Load, dt: float, state: RodState, work: ImplicitWork) -> None:
    """Advance `state` by dt [s] under its load: linearly implicit, O(N), no iteration, no allocation.

    Order: 2 in the pose. state.v is carried in the directions that the hinges had at the middle of the step, so as the
    velocity at its end it is of order 1; `meet_hinges` gives that one, to order 2. Modes faster than the step die
    within a few steps instead of being followed.
    Stability: about a rest in which no force topples a rod no small motion grows, for any dt, N, stiffness, damping,
    gravity, load and springs. To first order all of them are in L below, which is then dissipative, and the method's
    R(dt L) is a contraction (von Neumann). Without gravity, load and springs that holds of every motion.
    Energy: H after <= H before + damping's work + the load's work - lift, exactly and for every dt, where only lift is
    not in the true balance: order dt^3 a step, of third order in the motion where no rod is toppled, and none without
    gravity, load and springs. The reflection keeps H, the projection into the frozen directions lowers it, and the
    frozen motion y' = L y + f loses (GAMMA^2 dt^3 / 2) (GAMMA^2 dt |L^2 x|^2 - <L L x, L x>) >= 0 with
    x = (1 - GAMMA dt L)^-2 (y - its rest).
    Hinges stay closed to rounding, for ever.
    Not in the paper, which has RK4 ("Hardware setup": ode4). In place: state, work.
    """
    half, g = 0.5 * dt, GAMMA * dt
    for i in range(work.theta.size):
        work.theta[i] = state.q[2, i] + half * state.v[2, i]
    rotations(state.q[2], model.arm, work.a)
    begin_step(load.springs, model.arm, state.q, work.a, work.points)
    turn_velocity(model, 2.0, state.v, work)
    rotations(work.theta, model.arm, work.a)
    assemble(model, g, work.a, work.block)
    hold_springs(model, g, load.springs, work.a, work.block)
    hang_rods(model, load, g, state.q[2], work)
    factorise(work.block)
    work.lift[0] = -hung(state.q[2], work)
    stage(model, state, load, g, work, work.v)
    between_stages(work.v, dt, state)
    go_on(load.springs, model.arm, (1.0 - GAMMA) * dt, work.v, work.a, work.points)
    stage(model, state, load, g, work, state.v)
    after_stages(dt, state, work.v)
    work.lift[0] += hung(state.q[2], work)
    end_step(load.springs, model.arm, dt, work.v, work.a, work.points)
    rotations(state.q[2], model.arm, work.a)
    close_hinges(model, dt, state, work)


@inlined
def turn_velocity(model: RodModel, share: float, v: Array, work: ImplicitWork) -> None:
    """Add share M^-1 A^T lambda to v, where A M^-1 A^T lambda = -A v: 1 projects v on A v = 0, 2 reflects it there.

    Not in the paper: part of `implicit_step`. In place: v (3,N), work.
    """
    a, r, lam = work.a, work.r, work.lam
    distal_x = distal_y = 0.0
    for i in range(r.shape[1]):
        end_x, end_y = v[2, i] * a[0, i], v[2, i] * a[1, i]
        r[0, i] = share * (distal_x - (v[0, i] - end_x))
        r[1, i] = share * (distal_y - (v[1, i] - end_y))
        distal_x, distal_y = v[0, i] + end_x, v[1, i] + end_y
    eliminate(model, a, r, work.G)
    substitute(work.G, r, lam)
    apply_hinges(model, a, v, lam, v)


@kernel
def meet_hinges(model: RodModel, q: Array, v: Array, work: ImplicitWork) -> None:
    """Project v (3,N) on the velocities that the hinges allow in the pose q (3,N); kinetic energy cannot rise.

    A q' = 0: paper, "Stability and Passivity Analysis", of admissible velocities. In place: v, work.
    """
    rotations(q[2], model.arm, work.a)
    turn_velocity(model, 1.0, v, work)


@inlined
def assemble(model: RodModel, g: float, a: Array, out_block: Block) -> None:
    """The matrix M + g B + g^2 K of a stage, g = GAMMA dt [s]; mass-proportional damping makes the masses heavier.

    Not in the paper: part of `implicit_step`. Sets all of out_block that makes up the matrix.
    """
    heavier = 1.0 + g * model.alpha
    outer = 0.0
    for i in range(model.k.size - 1, -1, -1):
        inner = g * (model.b[i] + g * model.k[i])
        out_block.H[i] = heavier * model.I[i] + inner + outer
        out_block.h[i] = inner
        for axis in range(2):
            out_block.w[axis, i + 1] = model.m_inv[i] / heavier
            out_block.prox[axis, i] = out_block.dist[axis, i] = a[axis, i]
            out_block.lean[axis, i] = 0.0
        outer = inner


@inlined
def hold_springs(model: RodModel, g: float, springs: Springs, a: Array, block: Block) -> None:
    """Add g B_o + g^2 K_o at the points of the springs to the matrix.

    Eliminating x and y of a rod that is held off its centre leaves it heavier, and its ends turn about another point.
    Not in the paper: part of `implicit_step`. In place: block.
    """
    j, count = 0, springs.active[0]
    while j < count:
        i, held, first, second = springs.rod[j], 0.0, 0.0, 0.0
        while j < count and springs.rod[j] == i:
            share = springs.offset[j] / model.arm[i]
            held, first, second = held + 1.0, first + share, second + share * share
            j += 1
        for axis in range(2):
            weight = g * (springs.B[axis] + g * springs.K[axis])
            w = 1.0 / (1.0 / block.w[axis, i + 1] + weight * held)
            off, ax = weight * first * w, a[axis, i]
            block.w[axis, i + 1], block.lean[axis, i] = w, weight * first * ax
            block.prox[axis, i], block.dist[axis, i] = (1.0 + off) * ax, (1.0 - off) * ax
            block.H[i] += weight * (second - off * first) * ax * ax


@inlined
def hang_rods(model: RodModel, load: Load, g: float, theta: Array, work: ImplicitWork) -> None:
    """Add g^2 D to the matrix, where rods turn by `theta_middle - theta` (N,) [rad] in half of the step.

    A force of one direction has a potential of cosines, one of each angle, so its second derivatives are a diagonal:
    c_i times what pulls along rod i, at it and beyond it. A rod that is pushed would be toppled; that is left out, as
    with it the matrix would lose its sign. In a turn of radians a cosine is flatter than its parabola.
    Not in the paper: part of `implicit_step`. In place: work.
    """
    springs, a = load.springs, work.a
    beyond_x = beyond_y = 0.0
    j = springs.active[0] - 1
    for i in range(model.m.size - 1, -1, -1):
        own_x, own_y = model.m[i] * model.g[0] + load.F[0, i], model.m[i] * model.g[1] + load.F[1, i]
        pull_x, pull_y = own_x + 2.0 * beyond_x, own_y + 2.0 * beyond_y
        beyond_x, beyond_y = beyond_x + own_x, beyond_y + own_y
        while j >= 0 and springs.rod[j] == i:
            f_x, f_y = held_force(springs, work.points, j)
            share = 1.0 + springs.offset[j] / model.arm[i]
            pull_x, pull_y = pull_x + share * f_x, pull_y + share * f_y
            beyond_x, beyond_y, j = beyond_x + f_x, beyond_y + f_y, j - 1
        turn = work.theta[i] - theta[i]
        work.hang[i] = max(0.0, pull_x * a[1, i] - pull_y * a[0, i]) / (1.0 + turn * turn / 12.0)
        work.block.H[i] += g * g * work.hang[i]


@inlined
def hung(theta: Array, work: ImplicitWork) -> float:
    """What D holds at the angles theta (N,) [J], 0 at the middle of the step. Not in the paper: see `hang_rods`."""
    total = 0.0
    for i in range(theta.size):
        turn = theta[i] - work.theta[i]
        total += 0.5 * work.hang[i] * turn * turn
    return total


@inlined
def held_force(springs: Springs, points: Points, j: int) -> tuple[float, float]:
    """Force along x and y of spring j on its point where that is, standing still [N].

    Eq. OBS: paper, "Dynamic observer".
    """
    f_x = springs.K[0] * (springs.anchor[j, 0] - points.at[j, 0]) + springs.B[0] * springs.rate[j, 0]
    f_y = springs.K[1] * (springs.anchor[j, 1] - points.at[j, 1]) + springs.B[1] * springs.rate[j, 1]
    return f_x, f_y


@inlined
def stage(model: RodModel, state: RodState, load: Load, g: float, work: ImplicitWork, out_v: Array) -> None:
    """Velocity V = v_c + g V' (3,N) of a stage, where `state` holds v_c and the angles theta_c.

    `out_v` may be state.v. Not in the paper: part of `implicit_step`. In place: work.
    """
    block, q = work.block, state.q
    last = block.z.size - 1
    before_x = before_y = 0.0
    inner = model.k[0] * (q[2, 0] - model.bend[0])
    for i in range(last + 1):
        outer = model.k[i + 1] * (q[2, i + 1] - q[2, i] - model.bend[i + 1]) if i < last else 0.0
        x = block.w[0, i + 1] * (model.m[i] * (state.v[0, i] + g * model.g[0]) + g * load.F[0, i])
        y = block.w[1, i + 1] * (model.m[i] * (state.v[1, i] + g * model.g[1]) + g * load.F[1, i])
        turned = block.lean[0, i] * x + block.lean[1, i] * y
        held = work.hang[i] * (q[2, i] - work.theta[i])
        block.r[i, 0] = model.I[i] * state.v[2, i] + g * (load.Q_theta[i] + outer - inner - held) - turned
        block.r[i, 1], block.r[i, 2] = x - before_x, y - before_y
        before_x, before_y, inner = x, y, outer
    pull_stage(model, load.springs, g, work)
    solve_blocks(block)
    follow_hinges(work.a, block.z, out_v)


@inlined
def pull_stage(model: RodModel, springs: Springs, g: float, work: ImplicitWork) -> None:
    """Add what the springs do where the points are as the stage begins to its right-hand side.

    Eq. OBS: paper, "Dynamic observer"; what of it goes with the stage's velocity is in the matrix. In place: work.
    """
    block, a = work.block, work.a
    r, last = block.r, block.z.size - 1
    for j in range(springs.active[0]):
        i = springs.rod[j]
        f_x, f_y = held_force(springs, work.points, j)
        x, y = g * block.w[0, i + 1] * f_x, g * block.w[1, i + 1] * f_y
        turn = springs.offset[j] / model.arm[i] * (a[0, i] * f_x + a[1, i] * f_y)
        r[i, 0] += g * turn - (block.lean[0, i] * x + block.lean[1, i] * y)
        r[i, 1], r[i, 2] = r[i, 1] + x, r[i, 2] + y
        if i < last:
            r[i + 1, 1], r[i + 1, 2] = r[i + 1, 1] - x, r[i + 1, 2] - y


@inlined
def follow_hinges(a: Array, omega: Array, out_v: Array) -> None:
    """Velocities (3,N) of a chain that turns by omega (N,) [rad/s] in the hinges' directions a (2,N) [m].

    A q' = 0: paper, "Stability and Passivity Analysis", of admissible velocities.
    """
    x = y = 0.0
    for i in range(omega.size):
        turn = flushed(omega[i])
        step_x, step_y = turn * a[0, i], turn * a[1, i]
        out_v[0, i], out_v[1, i], out_v[2, i] = x + step_x, y + step_y, turn
        x, y = x + 2.0 * step_x, y + 2.0 * step_y


@inlined
def between_stages(v: Array, dt: float, state: RodState) -> None:
    """v_c and theta_c of the second stage, (1 - GAMMA) dt along the slope of the first, whose velocity is v (3,N).

    Not in the paper: part of `implicit_step`. In place: state.
    """
    share = (1.0 - GAMMA) / GAMMA
    for i in range(v.shape[1]):
        for row in range(3):
            state.v[row, i] += share * (v[row, i] - state.v[row, i])
        state.q[2, i] += (1.0 - GAMMA) * dt * v[2, i]


@inlined
def after_stages(dt: float, state: RodState, v: Array) -> None:
    """The step's last angles, and its mean velocity in place of the first stage's.

    Not in the paper: part of `implicit_step`. In place: state.q, v (3,N).
    """
    for i in range(v.shape[1]):
        for row in range(3):
            v[row, i] = (1.0 - GAMMA) * v[row, i] + GAMMA * state.v[row, i]
        state.q[2, i] = flushed(state.q[2, i] + GAMMA * dt * state.v[2, i])


@inlined
def close_hinges(model: RodModel, dt: float, state: RodState, work: ImplicitWork) -> None:
    """Put x and y where the angles say, and add gravity's work on what that adds to the frozen motion to `lift`.

    phi_H(q) = 0: paper, "Constrained Dynamic Model". In place: state.q, work.lift.
    """
    q, v, a, g_x, g_y = state.q, work.v, work.a, model.g[0], model.g[1]
    x = y = lift = 0.0
    for i in range(q.shape[1]):
        centre_x, centre_y = x + a[1, i], y - a[0, i]
        off_x, off_y = centre_x - q[0, i] - dt * v[0, i], centre_y - q[1, i] - dt * v[1, i]
        lift += model.m[i] * (g_x * off_x + g_y * off_y)
        q[0, i], q[1, i] = centre_x, centre_y
        x, y = x + 2.0 * a[1, i], y - 2.0 * a[0, i]
    work.lift[0] += lift


@kernel
def book_implicit_step(
    model: RodModel, state: RodState, load: Load, u: Array, dt: float, work: ImplicitWork, ledger: Ledger
) -> float:
    """Book the `implicit_step` of dt [s] just made; returns H - given [J], which only falls: minus numerical damping.

    The powers are those of the step's mean velocity: that makes the work of the held load exact and every step's share
    of H - given negative. In place of Baumgarte's power stands that of closing the hinges, -lift / dt. As in
    `ledger_step`, `u` (2,) [N m] is the part of the load that is pneumatic. Paper, "Stability and Passivity Analysis",
    but for what the method itself loses. In place: ledger.
    """
    power = ledger.power
    power[DAMPING] = damping_power(model, work.v)
    power[PNEUMATIC] = pneumatic_power(model, u, work.v)
    power[OBSERVER] = work.points.power[0] + load_power(load, work.v) - power[PNEUMATIC]
    power[BAUMGARTE] = -work.lift[0] / dt
    ledger.energy[0] = stored_energy(model, state.q, state.v)
    for i in range(power.size):
        ledger.given[0] += dt * power[i]
    return ledger.energy[0] - ledger.given[0]
