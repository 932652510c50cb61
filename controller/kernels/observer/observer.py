"""The dynamic observer: the rod model, driven by the sent torques and pulled to the markers by virtual forces."""

import math
from typing import NamedTuple

from controller.arrays import Array, Record, Words
from controller.kernels.compiled import kernel
from controller.kernels.memory import Sensing
from controller.kernels.model.energy import Ledger, ledger_step, open_ledger
from controller.kernels.model.implicit import ImplicitWork, book_implicit_step, implicit_step
from controller.kernels.model.integrate import rk4_step
from controller.kernels.model.pneumatics import delay, first_order_lag
from controller.kernels.model.rod import Load, RodModel, RodState, Work
from controller.kernels.model.statics import Places, points_on, pose
from controller.schema.modes import Integrator

TIP = 1 << 9
"""The bit of the sensor at the tip."""


class ObserverGains(NamedTuple):
    """Gains of the virtual forces along x and y."""

    K_o: Array
    """(2,) [N/m]."""
    B_o: Array
    """(2,) [N s/m]."""


class Observer(NamedTuple):
    """The observer's model and its memory."""

    model: RodModel
    state: RodState
    load: Load
    integrator: int
    work: Work
    """Scratch of RK4."""
    implicit_work: ImplicitWork
    ledger: Ledger
    dt: float
    gains: ObserverGains
    B_max: float
    """Most damping of a virtual force that a step can hold: it would stop the tip within the step [N s/m]."""
    dead_time: Array
    """Ring of the sent torques (ticks of dead time + 1, 2) [N m]."""
    head: Words
    """(1,) place of the next torque in the ring."""
    lag: float
    """Time constant of the chambers [s]."""
    u_hat: Array
    """Torques that act on the model (2,) [N m]."""
    sensors: Places
    """The markers' material points (10)."""
    backbone: Places
    """The telemetry's backbone points (21)."""
    points: Array
    """The model's position at the sensors (10,2) [m]."""


class Replay(NamedTuple):
    """The model of a recorded body and its memory, for `replay`; fields that it shares with Observer have its names."""

    model: RodModel
    state: RodState
    load: Load
    work: ImplicitWork
    sensors: Places
    """Material points of the tracked bodies (m)."""
    points: Array
    """The model's position there (m,2) [m]."""
    held: Array
    """Torques that held the pose before the release (N,) [N m]."""
    release: Array
    """(2,) when they begin to fade, and for how long they do [s]."""
    dt: float


class HeldSample(NamedTuple):
    """One sample of a recording, with the fields of Sensing that `pull` reads."""

    p: Array
    v: Array
    age: Array


@kernel
def advance_pneumatics(u1: float, u2: float, observer: Observer) -> None:
    """Pass u [N m] through dead time and lag: the torques that act on the model now (paper, "Dynamic observer").

    In place: observer.dead_time, observer.head, observer.u_hat.
    """
    late_1, late_2, observer.head[0] = delay(u1, u2, observer.head[0], observer.dead_time)
    observer.u_hat[0] = first_order_lag(observer.u_hat[0], late_1, observer.lag, observer.dt)
    observer.u_hat[1] = first_order_lag(observer.u_hat[1], late_2, observer.lag, observer.dt)


@kernel
def pressurise(observer: Observer) -> None:
    """Load of the chambers alone: Q_theta = T_theta u_hat (paper, "Parameter Estimation"). In place: observer.load."""
    load, T = observer.load, observer.model.T_theta
    for i in range(T.shape[0]):
        load.Q_theta[i] = T[i, 0] * observer.u_hat[0] + T[i, 1] * observer.u_hat[1]
        load.F[0, i] = load.F[1, i] = 0.0


@kernel
def pull(sensing: Sensing | HeldSample, gains: ObserverGains, used: int, h: float, observer: Observer | Replay) -> None:
    """Add the virtual forces of the used sensors to the load. Eq. OBS: paper, "Dynamic observer".

    The residual is taken at the sensor's arc length, the force enters the centre of the rod that holds it. For the tip
    alone that is the paper's law. Springs at several rods, or strong ones further in, would then feed energy and
    flutter, so there each spring also turns its rod, as if it pulled at the marker: that is passive. A force is held
    for one step of h [s], so it is taken at the step's middle: taken at its start, the spring would feed energy too.
    In place: observer.load, observer.points.
    """
    load, q, v = observer.load, observer.state.q, observer.state.v
    turn, p, p_dot, age = 0.0 if used == TIP else 1.0, sensing.p, sensing.v, sensing.age[0]
    points_on(q, observer.sensors, observer.points)
    for j in range(observer.points.shape[0]):
        if used >> j & 1:
            i = observer.sensors.rod[j]
            x, y = observer.points[j]
            r_x, r_y = x - q[0, i], y - q[1, i]
            x_dot, y_dot = v[0, i] - v[2, i] * r_y, v[1, i] + v[2, i] * r_x
            e_x = p[j, 0] + age * p_dot[j, 0] - x - 0.5 * h * x_dot
            e_y = p[j, 1] + age * p_dot[j, 1] - y - 0.5 * h * y_dot
            k_x, k_y = gains.K_o[0] * e_x, gains.K_o[1] * e_y
            load.F[0, i] += k_x + gains.B_o[0] * (p_dot[j, 0] - x_dot)  # Eq. OBS
            load.F[1, i] += k_y + gains.B_o[1] * (p_dot[j, 1] - y_dot)  # Eq. OBS
            load.Q_theta[i] += turn * (r_x * k_y - r_y * k_x)


@kernel
def observe(sensing: Sensing, settings: Record, ticks: int, state: Record, observer: Observer) -> None:
    """Advance the observer by `ticks` periods under the torques sent last: 1, or more to catch up after a stall.

    Paper, "Dynamic observer". In place: state.forget, observer.
    """
    if state.forget:
        reset_observer(observer)
        state.forget = 0
    choose_gains(settings, observer)
    for _ in range(ticks):
        advance_pneumatics(state.u[0], state.u[1], observer)
        pressurise(observer)
        pull(sensing, observer.gains, state.used, observer.dt, observer)
        step_observer(observer)


@kernel
def choose_gains(settings: Record, observer: Observer) -> None:
    """Gains in force: those of the settings, with the damping that one step can hold at most.

    The force is held for a step: more damping would throw the model beyond the marker's velocity, more each time.
    Not in the paper, where B_o = 0. In place: observer.gains.
    """
    for j in range(2):
        observer.gains.K_o[j] = settings.K_o[j]
        observer.gains.B_o[j] = min(settings.B_o[j], observer.B_max)


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
    for j in range(2):
        observer.u_hat[j] = 0.0
        for slot in range(observer.dead_time.shape[0]):
            observer.dead_time[slot, j] = 0.0
    open_ledger(observer.model, observer.state, observer.ledger)
