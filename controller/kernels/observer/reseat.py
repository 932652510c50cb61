"""A knotted observer is set again, from the static pose that fits the markers.

A whip can wind the model's angles once more than the arm's. The markers then still fit, all but for some millimetres,
and nothing pulls it back: the wound pose is a minimum of its energy, too, of the hinges and of the virtual springs
together, but a higher one than that of the pose in which the arm is. Not in the paper, whose observer has one start.
"""

import math

from controller.arrays import Array, Pair, Record
from controller.kernels.compiled import kernel
from controller.kernels.memory import Control, Sensing
from controller.kernels.model.energy import open_ledger
from controller.kernels.model.equilibrium import energy, under_pressure
from controller.kernels.model.polygon import nearest_admissible
from controller.kernels.model.statics import points_on, pose, static_pose
from controller.kernels.observer.observer import Observer, ReseatState

LOOK_EVERY = 0.1
"""From one look at the pose to the next [s]."""
KNOTTED_TIME = 0.5
"""For how long it must be off before a pose is fitted, and again after one that was no better [s]."""
APART = 1.0
"""A pose with every angle nearer than this to that of the torques alone is not knotted [rad]."""
SLOW = 0.5
"""In an arm that moves faster the angles may be off for a while [m/s]."""
FIT_TICKS = 24
"""One step of the fit a tick."""
MOVE_TIME = 0.2
"""For which the model is then moved over [s]."""
PROBE = 1e-3
"""Step of u with which the slopes are taken, as a share of u_max."""


@kernel
def reseat(sensing: Sensing, control: Control, observer: Observer, out_telemetry: Record) -> None:
    """Look whether the pose is wound; if so fit a static pose to the markers, and move the model there if it is better.

    Fills out_telemetry.reseats. Not in the paper. In place: control.scratch, observer.
    """
    state, seat = control.state[0], observer.seat
    stage = seat.stage[0]
    if stage == 0:
        if wound(state, sensing, observer, control, seat):
            begin_fit(observer, seat)
    elif stage <= FIT_TICKS:
        fit(state.used, sensing, observer, control, seat)
        if stage == FIT_TICKS and not better(state.used, sensing, control, observer, seat):
            seat.stage[0], seat.off[0] = 0, 0.0
    else:
        move_over(observer, seat)
    out_telemetry.reseats = seat.made[0]


@kernel
def is_moved_over(seat: ReseatState) -> bool:
    """Whether the model is on its way to another pose: its tip is no tip to feed back then, nor is S its own.

    Not in the paper: see `reseat`.
    """
    return seat.stage[0] > FIT_TICKS


@kernel
def wound(state: Record, sensing: Sensing, observer: Observer, control: Control, seat: ReseatState) -> bool:
    """Whether a slow arm's model has been far from the pose of its torques for long. Not in the paper: see `reseat`.

    In place: control.scratch, seat.off.
    """
    every = max(1, int(LOOK_EVERY / observer.dt + 0.5))
    if state.tick % every != 0:
        return False
    springs, theta = observer.load.springs, observer.state.q[2]
    if state.used == 0 or springs.K[0] + springs.K[1] == 0.0 or not sensing.fast[0] < SLOW:
        return False
    static_pose(control.smap.statics, observer.torque[0], observer.torque[1], control.scratch)
    apart = 0.0
    for i in range(theta.size):
        apart = max(apart, abs(theta[i] - control.scratch.theta[i]))
    seat.off[0] = seat.off[0] + LOOK_EVERY if apart > APART else 0.0
    return seat.off[0] > KNOTTED_TIME


@kernel
def begin_fit(observer: Observer, seat: ReseatState) -> None:
    """Begin with the torques that the model believes in. Not in the paper: see `reseat`. In place: seat."""
    seat.stage[0], seat.cost[0] = 1, math.inf
    for j in range(2):
        seat.u[j], seat.step[j] = observer.torque[j], 0.0


@kernel
def fit(used: int, sensing: Sensing, observer: Observer, control: Control, seat: ReseatState) -> None:
    """One step of Gauss-Newton on the torques whose static pose fits the used markers, or half of the one before.

    Not in the paper: see `reseat`. In place: control.scratch, seat.
    """
    polygon = control.smap.polygon
    u1, u2 = nearest_admissible(polygon, seat.u[0] + seat.step[0], seat.u[1] + seat.step[1])
    cost = distance_left(used, (u1, u2), 0, sensing, observer, control, seat)
    if cost < seat.cost[0]:
        probe = PROBE * polygon.bounds[0]
        distance_left(used, (u1 + probe, u2), 1, sensing, observer, control, seat)
        distance_left(used, (u1, u2 + probe), 2, sensing, observer, control, seat)
        seat.step[0], seat.step[1] = best_step(used, probe, control.controller[0].epsilon, sensing, seat)
        seat.u[0], seat.u[1], seat.cost[0] = u1, u2, cost
    else:
        for j in range(2):
            seat.step[j] *= 0.5
    seat.stage[0] += 1


@kernel
def distance_left(
    used: int, u: Pair, row: int, sensing: Sensing, observer: Observer, control: Control, seat: ReseatState
) -> float:
    """Sum of the squared distances [m^2] of the used markers from the static pose at u [N m].

    Not in the paper: see `reseat`. In place: control.scratch, seat.
    """
    static_pose(control.smap.statics, u[0], u[1], control.scratch)
    pose(observer.model, control.scratch.theta, seat.q)
    points_on(seat.q, observer.sensors, seat.points[row])
    total = 0.0
    for j in range(sensing.p.shape[0]):
        if used >> j & 1:
            for axis in range(2):
                total += (sensing.p[j, axis] - seat.points[row, j, axis]) ** 2
    return total


@kernel
def best_step(used: int, probe: float, epsilon: float, sensing: Sensing, seat: ReseatState) -> Pair:
    """(J^T J + epsilon I)^-1 J^T r [N m] of the used points, by the differences over `probe` [N m].

    As Eq. FF: paper, "Quasi-Static Feedforward Control", there for the tip alone.
    """
    H11, H12, H22, g1, g2 = epsilon, 0.0, epsilon, 0.0, 0.0
    for j in range(sensing.p.shape[0]):
        if used >> j & 1:
            for axis in range(2):
                r = sensing.p[j, axis] - seat.points[0, j, axis]
                J1 = (seat.points[1, j, axis] - seat.points[0, j, axis]) / probe
                J2 = (seat.points[2, j, axis] - seat.points[0, j, axis]) / probe
                H11, H12, H22 = H11 + J1 * J1, H12 + J1 * J2, H22 + J2 * J2
                g1, g2 = g1 + J1 * r, g2 + J2 * r
    det = H11 * H22 - H12 * H12
    return (H22 * g1 - H12 * g2) / det, (H11 * g2 - H12 * g1) / det


@kernel
def better(used: int, sensing: Sensing, control: Control, observer: Observer, seat: ReseatState) -> bool:
    """Whether the pose that was fitted has less energy than the model's, under the same torques and springs.

    The model is at a minimum, so a pose that has less is another one: no arm that is pushed, nor a poor model, can be
    taken for a knot. Not in the paper: see `reseat`. In place: control.scratch, observer.points, seat.
    """
    distance_left(used, (seat.u[0], seat.u[1]), 0, sensing, observer, control, seat)
    apart = 0.0
    for i in range(seat.begin.size):
        seat.begin[i] = observer.state.q[2, i]
        apart = max(apart, abs(seat.q[2, i] - seat.begin[i]))
    points_on(observer.state.q, observer.sensors, observer.points)
    there = potential(used, seat.q[2], seat.points[0], sensing, observer, control)
    return apart > APART and there < potential(used, seat.begin, observer.points, sensing, observer, control)


@kernel
def potential(used: int, theta: Array, points: Array, sensing: Sensing, observer: Observer, control: Control) -> float:
    """Energy [J], but for a constant, of the pose theta (N,) under the model's torques and springs; its points (10,2).

    Not in the paper: see `reseat`. In place: control.scratch.
    """
    u_1, u_2 = observer.torque[0], observer.torque[1]
    total = energy(under_pressure(control.smap.statics.body, u_1, u_2, control.scratch), u_1, u_2, theta)
    for j in range(points.shape[0]):
        if used >> j & 1:
            for axis in range(2):
                total += 0.5 * observer.load.springs.K[axis] * (sensing.p[j, axis] - points[j, axis]) ** 2
    return total


@kernel
def move_over(observer: Observer, seat: ReseatState) -> None:
    """Move the model on towards the pose that was fitted: it begins and ends smoothly, and without velocity.

    Not in the paper: see `reseat`. In place: observer, seat.
    """
    state = observer.state
    seat.stage[0] += 1
    share = min(1.0, (seat.stage[0] - FIT_TICKS) * observer.dt / MOVE_TIME)
    share *= share * (3.0 - 2.0 * share)
    for i in range(seat.begin.size):
        seat.theta[i] = seat.begin[i] + share * (seat.q[2, i] - seat.begin[i])
    pose(observer.model, seat.theta, state.q)
    for row in range(3):
        for i in range(seat.begin.size):
            state.v[row, i] = 0.0
    open_ledger(observer.model, state, observer.ledger)
    if share >= 1.0:
        seat.stage[0], seat.off[0] = 0, 0.0
        seat.made[0] += 1
