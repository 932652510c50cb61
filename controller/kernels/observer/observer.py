"""The dynamic observer: the rod model, driven by the sent torques and pulled to the markers by virtual forces."""

import math

import numpy as np

from controller.arrays import Array, Record, Words
from controller.kernels.compiled import kernel
from controller.kernels.group import Group
from controller.kernels.memory import Control, Sensing
from controller.kernels.model.energy import Ledger, ledger_step, open_ledger, stored_energy
from controller.kernels.model.implicit import ImplicitWork, book_implicit_step, implicit_step
from controller.kernels.model.integrate import rk4_step
from controller.kernels.model.pneumatics import delay, first_order_lag
from controller.kernels.model.pressed import Unpressed, close_up, is_pressed, press_chain
from controller.kernels.model.rod import Load, RodModel, RodState, Work
from controller.kernels.model.statics import Places, points_on, pose
from controller.kernels.observer.prediction import Prediction, foresee, learn, predict, reset_prediction
from controller.kernels.safety.chamber_watch import chambers_broken
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
    pull_max: float
    """Most that one spring pulls with [N]."""
    gain_max: Array
    """(2,) most K_o [N/m] and B_o [N s/m] with which the integrator is stable, see `stability.largest_gains`."""
    dead_time: Array
    """Ring of the sent torques (ticks of dead time + 1, 2) [N m]."""
    head: Words
    """(1,) place of the next torque in the ring."""
    lag: float
    """Time constant of the chambers [s]."""
    u_hat: Array
    """What of the sent torques has come through dead time and lag (2,) [N m]."""
    level_hat: Array
    """Levels of the pairs' pressures with them, as of `under_levels` (2,) [N m]."""
    torque: Array
    """Torques that act on the model (2,) [N m]: those of the measured pressures, or u_hat."""
    level: Array
    """Levels of the pairs' pressures with them (2,) [N m]."""
    unpressed: Unpressed
    sensors: Places
    """The markers' material points (10)."""
    backbone: Places
    """The telemetry's backbone points (21)."""
    points: Array
    """The model's position at the sensors (10,2) [m]."""
    seat: ReseatState
    predicts: bool
    """Whether `prediction` says where the markers are between their samples."""
    prediction: Prediction


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


def make_reseat_state(rods: int, sensors: int) -> ReseatState:
    """Nothing is wrong with a chain of `rods`, tracked at `sensors` points."""
    off, cost = np.zeros((2, 1))
    stage, made = np.zeros((2, 1), np.int64)
    (u, step), (begin, theta) = np.zeros((2, 2)), np.zeros((2, rods))
    return ReseatState(off, stage, made, begin, u, step, cost, theta, np.zeros((3, rods)), np.zeros((3, sensors, 2)))


@kernel
def advance_pneumatics(u1: float, u2: float, observer: Observer) -> None:
    """Pass u [N m] through dead time and lag: what should act on the model now (paper, "Dynamic observer").

    In place: observer.dead_time, observer.head, observer.u_hat, observer.level_hat.
    """
    late_1, late_2, observer.head[0] = delay(u1, u2, observer.head[0], observer.dead_time)
    observer.u_hat[0] = first_order_lag(observer.u_hat[0], late_1, observer.lag, observer.dt)
    observer.u_hat[1] = first_order_lag(observer.u_hat[1], late_2, observer.lag, observer.dt)
    observer.level_hat[0] = first_order_lag(observer.level_hat[0], abs(late_1), observer.lag, observer.dt)
    observer.level_hat[1] = first_order_lag(observer.level_hat[1], abs(late_2), observer.lag, observer.dt)


@kernel
def believe_torques(observer: Observer) -> None:
    """The torques that act on the model are those that dead time and lag leave (paper, "Dynamic observer").

    In place: observer.torque, observer.level.
    """
    for j in range(2):
        observer.torque[j], observer.level[j] = observer.u_hat[j], observer.level_hat[j]


@kernel
def measure_torques(p: Array, pascal_per_torque: Array, behind: int, observer: Observer) -> None:
    """They are those of the pressures p (4,) [Pa]; `behind` ticks before those were read a share on the way there.

    Not in the paper, whose observer has no pressures. In place: observer.torque, observer.level.
    """
    share = 1.0 / (behind + 1.0)
    for j in range(2):
        one, other = p[2 * j] / pascal_per_torque[2 * j], p[2 * j + 1] / pascal_per_torque[2 * j + 1]
        observer.torque[j] += share * (one - other - observer.torque[j])
        observer.level[j] += share * (one + other - observer.level[j])


@kernel
def pressurise(observer: Observer) -> None:
    """Load of the chambers alone: Q_theta = T_theta u (paper, "Parameter Estimation"), how stiff and how long they
    make it.

    In place: observer.
    """
    load, model = observer.load, observer.model
    T = model.T_theta
    if is_pressed(model):
        press_model(observer)
    for i in range(T.shape[0]):
        load.Q_theta[i] = T[i, 0] * observer.torque[0] + T[i, 1] * observer.torque[1]


@kernel
def press_model(observer: Observer) -> None:
    """Stiffness and lengths under the pairs' pressures.

    They do work on what is bent or hangs, which the ledger has. Not in the paper, where no pressure changes them.
    In place: observer.
    """
    model, state, level = observer.model, observer.state, observer.level
    before = stored_energy(model, state.q, state.v)
    press_chain(level[0], level[1], observer.unpressed, model, observer.sensors, observer.backbone)
    close_up(model, state.q)
    close_up(model, observer.prediction.state.q)
    observer.ledger.given[0] += stored_energy(model, state.q, state.v) - before


@kernel
def attach(p: Array, v: Array, age: float, used: int, observer: Observer | Replay) -> None:
    """Hang a virtual spring on the measured point of each used sensor. Eq. OBS: paper, "Dynamic observer".

    Points p (n,2) [m] are carried on with v (n,2) [m/s] by `age` [s]. A spring pulls at the sensor's own point
    (`springs.py`) as the step goes on, so the measured point, which is the same for the whole step, is that of its
    middle where it is carried on. In place: observer.load.springs.
    """
    springs, sensors, n = observer.load.springs, observer.sensors, 0
    for j in range(sensors.rod.size):
        if used >> j & 1:
            springs.rod[n], springs.offset[n] = sensors.rod[j], sensors.offset[j]
            for axis in range(2):
                springs.anchor[n, axis] = p[j, axis] + age * v[j, axis]
                springs.rate[n, axis] = v[j, axis]
            n += 1
    springs.active[0] = n


@kernel
def hold_back(used: int, observer: Observer) -> None:
    """Let no spring pull with more than the arm's own torques would: a marker that comes back far off makes no whip.

    Not in the paper, whose springs are weak. In place: observer.load.springs.
    """
    springs, n = observer.load.springs, 0
    for j in range(observer.sensors.rod.size):
        if used >> j & 1:
            x, y = springs.anchor[n, 0] - observer.points[j, 0], springs.anchor[n, 1] - observer.points[j, 1]
            pull = math.hypot(springs.K[0] * x, springs.K[1] * y)
            if pull > observer.pull_max:
                springs.anchor[n, 0] = observer.points[j, 0] + x * observer.pull_max / pull
                springs.anchor[n, 1] = observer.points[j, 1] + y * observer.pull_max / pull
            n += 1


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
def observe(
    t_ns: int, settings: Record, measurement: Record, ticks: int, sensing: Sensing, control: Control, observer: Observer
) -> None:
    """Advance the observer to t_ns, by `ticks` periods under the torques sent last: 1, or more after a stall.

    Paper, "Dynamic observer". In place: control.state.forget, observer.
    """
    dt, prediction, state = observer.dt, observer.prediction, control.state[0]
    measured = control.controller[0].measured_torques and not chambers_broken(state, control.limits[0])
    if state.forget:
        reset_observer(observer)
        state.forget = 0
    choose_gains(settings, observer)
    damp_beyond(state.used, observer)
    for behind in range(ticks - 1, -1, -1):
        advance_pneumatics(state.u[0], state.u[1], observer)
        if measured:
            measure_torques(measurement.pressures, control.pascal_per_torque, behind, observer)
        else:
            believe_torques(observer)
        pressurise(observer)
        points_on(observer.state.q, observer.sensors, observer.points)
        if observer.predicts:
            end_ns = t_ns - int(1e9 * behind * dt)
            predict(dt, observer.load.Q_theta, observer.sensors, observer.implicit_work, prediction)
            if behind == 0:
                learn(end_ns, dt, sensing, prediction)
            foresee(end_ns, dt, prediction)
            attach(prediction.p, prediction.v, 0.0, state.used, observer)
        else:
            attach(sensing.p, sensing.v, sensing.age[0], state.used, observer)
        hold_back(state.used, observer)
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
    model, state, load, u, dt = observer.model, observer.state, observer.load, observer.torque, observer.dt
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
    press_chain(0.0, 0.0, observer.unpressed, observer.model, observer.sensors, observer.backbone)
    pose(observer.model, observer.model.rest, observer.state.q)
    for row in range(3):
        for i in range(observer.model.L.size):
            observer.state.v[row, i] = 0.0
    for j in range(2):
        observer.u_hat[j] = observer.level_hat[j] = observer.torque[j] = observer.level[j] = 0.0
        for slot in range(observer.dead_time.shape[0]):
            observer.dead_time[slot, j] = 0.0
    open_ledger(observer.model, observer.state, observer.ledger)
    observer.seat.stage[0], observer.seat.off[0] = 0, 0.0
    reset_prediction(observer.state, observer.sensors, observer.prediction)
