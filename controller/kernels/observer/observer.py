"""The dynamic observer: the rod model, driven by the sent torques and pulled to the markers by virtual forces."""

import math
from typing import NamedTuple

import numpy as np

from controller.arrays import Array, Record, Words
from controller.kernels.compiled import kernel
from controller.kernels.group import Group
from controller.kernels.memory import Sensing
from controller.kernels.model.energy import Ledger, bent_energy, ledger_step, open_ledger
from controller.kernels.model.implicit import ImplicitWork, book_implicit_step, implicit_step
from controller.kernels.model.integrate import rk4_step
from controller.kernels.model.pneumatics import delay, first_order_lag
from controller.kernels.model.rod import Load, RodModel, RodState, Work, stiffened
from controller.kernels.model.statics import Places, points_on, pose
from controller.schema.modes import Integrator

TIP = 1 << 9
"""The bit of the sensor at the tip."""


class ReseatState(Group):
    """Memory of `reseat`: how far it is, and the pose to which it leads."""

    off: Array
    """(1,) for how long the pose has been off, since a fit that was no better [s]."""
    stage: Words
    """(1,) 0 while nothing is wrong, then the ticks of the fit, then those of the move."""
    made: Words
    """(1,) moves made."""
    begin: Array
    """Angles from which the move began (N,) [rad]."""
    u: Array
    """Torques of the best pose so far (2,) [N m]."""
    step: Array
    """What is tried next from there (2,) [N m]."""
    cost: Array
    """(1,) sum of the squared distances that are left there [m^2]."""
    theta: Array
    """Angles on the way (N,) [rad]."""
    q: Array
    """The pose that is being tried (3,N)."""
    points: Array
    """Its points, and those a little beyond along u1 and u2 (3,10,2) [m]."""


class Observer(Group):
    """The observer's model and its memory."""

    model: RodModel
    state: RodState
    load: Load
    """The torques on the model, and the virtual springs."""
    integrator: int
    work: Work
    """Scratch of RK4."""
    implicit_work: ImplicitWork
    ledger: Ledger
    dt: float
    damping: Array
    """Of the hinges: the actuator's own, and that beyond the last sensed point (2,N) [N m s/rad]."""
    damped: Words
    """(1,) the rod that holds the last sensed point; N for none."""
    gain_max: Array
    """(2,) most K_o [N/m] and B_o [N s/m] with which the integrator is stable, see `stability.largest_gains`."""
    dead_time: Array
    """Ring of the sent torques (ticks of dead time + 1, 2) [N m]."""
    head: Words
    """(1,) place of the next torque in the ring."""
    lag: float
    """Time constant of the chambers [s]."""
    u_hat: Array
    """Torques that act on the model (2,) [N m]."""
    level: Array
    """Levels of the pairs' pressures in it, as of `stiffened` (2,) [N m]."""
    soft: Array
    """Stiffness of its hinges without pressure (N,) [N m/rad]."""
    sensors: Places
    """The markers' material points (10)."""
    backbone: Places
    """The telemetry's backbone points (21)."""
    points: Array
    """The model's position at the sensors (10,2) [m]."""
    seat: ReseatState


class Replay(Group):
    """The model of a recorded body and its memory, for `replay`; fields that it shares with Observer have its names."""

    model: RodModel
    state: RodState
    load: Load
    """With the gains of its springs."""
    work: ImplicitWork
    sensors: Places
    """Material points of the tracked bodies (m)."""
    held: Array
    """Torques that held the pose before the release (N,) [N m]."""
    release: Array
    """(2,) when they begin to fade, and for how long they do [s]."""
    dt: float


class HeldSample(NamedTuple):
    """One sample of a recording, with the fields of Sensing that `attach` reads."""

    p: Array
    v: Array
    age: Array


def make_reseat_state(rods: int, sensors: int) -> ReseatState:
    """Nothing is wrong with a chain of `rods`, tracked at `sensors` points."""
    off, cost = np.zeros((2, 1))
    stage, made = np.zeros((2, 1), np.int64)
    (u, step), (begin, theta) = np.zeros((2, 2)), np.zeros((2, rods))
    return ReseatState(off, stage, made, begin, u, step, cost, theta, np.zeros((3, rods)), np.zeros((3, sensors, 2)))


@kernel
def advance_pneumatics(u1: float, u2: float, observer: Observer) -> None:
    """Pass u [N m] through dead time and lag: the torques that act on the model now (paper, "Dynamic observer").

    In place: observer.dead_time, observer.head, observer.u_hat, observer.level.
    """
    late_1, late_2, observer.head[0] = delay(u1, u2, observer.head[0], observer.dead_time)
    observer.u_hat[0] = first_order_lag(observer.u_hat[0], late_1, observer.lag, observer.dt)
    observer.u_hat[1] = first_order_lag(observer.u_hat[1], late_2, observer.lag, observer.dt)
    observer.level[0] = first_order_lag(observer.level[0], abs(late_1), observer.lag, observer.dt)
    observer.level[1] = first_order_lag(observer.level[1], abs(late_2), observer.lag, observer.dt)


@kernel
def pressurise(observer: Observer) -> None:
    """Load of the chambers alone: Q_theta = T_theta u_hat (paper, "Parameter Estimation"), and how stiff they make it.

    In place: observer.load, observer.model.k, observer.ledger.
    """
    load, T = observer.load, observer.model.T_theta
    if observer.model.stiffening.shape[0] > 0:
        stiffen_hinges(observer)
    for i in range(T.shape[0]):
        load.Q_theta[i] = T[i, 0] * observer.u_hat[0] + T[i, 1] * observer.u_hat[1]


@kernel
def stiffen_hinges(observer: Observer) -> None:
    """Stiffness of the hinges under the pairs' pressures, which thereby do work on what is bent: the ledger has it.

    Not in the paper, whose stiffness no pressure changes. In place: observer.model.k, observer.ledger.
    """
    model, q = observer.model, observer.state.q
    before = bent_energy(model, q)
    stiffened(observer.soft, model.stiffening, observer.level[0], observer.level[1], model.k)
    observer.ledger.given[0] += bent_energy(model, q) - before


@kernel
def attach(sensing: Sensing | HeldSample, used: int, observer: Observer | Replay) -> None:
    """Hang a virtual spring on the measured point of each used sensor. Eq. OBS: paper, "Dynamic observer".

    It pulls at the sensor's own point (`springs.py`) as the step goes on, so the measured point, which is the same for
    the whole step, is that of its middle where it is carried on. In place: observer.load.springs.
    """
    springs, sensors, age, n = observer.load.springs, observer.sensors, sensing.age[0], 0
    for j in range(sensors.rod.size):
        if used >> j & 1:
            springs.rod[n], springs.offset[n] = sensors.rod[j], sensors.offset[j]
            for axis in range(2):
                springs.anchor[n, axis] = sensing.p[j, axis] + age * sensing.v[j, axis]
                springs.rate[n, axis] = sensing.v[j, axis]
            n += 1
    springs.active[0] = n


@kernel
def damp_beyond(used: int, observer: Observer) -> None:
    """Damp the hinges beyond the last used sensor: no spring reaches that part, which would swing by itself.

    The feedback of a tip that is only estimated drives such a swing. Nothing is fed back, and nothing damped, where
    nothing is sensed. Not in the paper. In place: observer.
    """
    last = observer.model.L.size
    for j in range(observer.sensors.rod.size):
        if used >> j & 1:
            last = observer.sensors.rod[j]
    if last != observer.damped[0]:
        observer.damped[0] = last
        for i in range(observer.model.b.size):
            observer.model.b[i] = observer.damping[1 if i > last else 0, i]


@kernel
def observe(sensing: Sensing, settings: Record, ticks: int, state: Record, observer: Observer) -> None:
    """Advance the observer by `ticks` periods under the torques sent last: 1, or more to catch up after a stall.

    Paper, "Dynamic observer". In place: state.forget, observer.
    """
    if state.forget:
        reset_observer(observer)
        state.forget = 0
    choose_gains(settings, observer)
    damp_beyond(state.used, observer)
    for _ in range(ticks):
        advance_pneumatics(state.u[0], state.u[1], observer)
        pressurise(observer)
        attach(sensing, state.used, observer)
        step_observer(observer)


@kernel
def choose_gains(settings: Record, observer: Observer) -> None:
    """K_o and B_o of the settings, which the server has held to what the integrator can do, and the rig holds again.

    Eq. OBS: paper, "Dynamic observer", where B_o = 0. In place: observer.load.springs.
    """
    springs, most = observer.load.springs, observer.gain_max
    for axis in range(2):
        springs.K[axis] = min(settings.K_o[axis], most[0])
        springs.B[axis] = min(settings.B_o[axis], most[1])


@kernel
def step_observer(observer: Observer) -> None:
    """One period of the model under its load, and its energy ledger.

    Paper, "Dynamic observer", integrates the constrained model. In place: observer.
    """
    model, state, load, u, dt = observer.model, observer.state, observer.load, observer.u_hat, observer.dt
    if observer.integrator == Integrator.IMPLICIT:
        implicit_step(model, load, dt, state, observer.implicit_work)
        book_implicit_step(model, state, load, u, dt, observer.implicit_work, observer.ledger)
    else:
        rk4_step(model, load, dt, state, observer.work)
        ledger_step(model, state, load, u, dt, observer.work, observer.ledger)


@kernel
def residual(sensing: Sensing, used: int, observer: Observer) -> float:
    """RMS distance between used markers and model [m]; nan when none is used.

    Of p_data - p_model: paper, "Dynamic observer". In place: observer.points.
    """
    points_on(observer.state.q, observer.sensors, observer.points)
    total, count = 0.0, 0
    for j in range(observer.points.shape[0]):
        if used >> j & 1:
            total += (sensing.p[j, 0] - observer.points[j, 0]) ** 2 + (sensing.p[j, 1] - observer.points[j, 1]) ** 2
            count += 1
    return math.sqrt(total / count) if count > 0 else math.nan


@kernel
def reset_observer(observer: Observer) -> None:
    """Back to the unactuated equilibrium, at rest, with nothing in the air lines.

    Initial conditions: paper, "Dynamic observer". In place: observer.
    """
    pose(observer.model, observer.model.rest, observer.state.q)
    for row in range(3):
        for i in range(observer.model.L.size):
            observer.state.v[row, i] = 0.0
    if observer.model.stiffening.shape[0] > 0:
        stiffened(observer.soft, observer.model.stiffening, 0.0, 0.0, observer.model.k)
    for j in range(2):
        observer.u_hat[j] = observer.level[j] = 0.0
        for slot in range(observer.dead_time.shape[0]):
            observer.dead_time[slot, j] = 0.0
    open_ledger(observer.model, observer.state, observer.ledger)
    observer.seat.stage[0], observer.seat.off[0] = 0, 0.0
