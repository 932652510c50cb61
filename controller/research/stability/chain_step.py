"""One tick of a chain as a matrix: what small deviations from a static pose become, found by the kernels themselves."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from controller.arrays import Array
from controller.assembly.equilibrium import body_of, carrying, imbalance, settle
from controller.assembly.stability import move, point_slopes
from controller.kernels.model.implicit import implicit_step
from controller.kernels.model.integrate import rk4_step
from controller.kernels.model.pressed import press_chain
from controller.kernels.model.rod import RodModel, RodState
from controller.kernels.model.statics import Places, chosen, points_on
from controller.kernels.observer.observer import Observer, attach, damp_beyond, pressurise, step_observer
from controller.kernels.plant.twin import Twin
from controller.realtime.compiled import compiled
from controller.schema.modes import Integrator
from controller.schema.parameters import SENSORS

DEVIATION = 1e-6
"""Angles [rad], rates [rad/s], torques and lengths are moved by this: differences are then right to 1e-9."""
DENSE = 200
"""Of larger matrices only the largest eigenvalues are looked for."""
TICKS, RESTS, STILL = 1000, 30, 1e-11
"""Ticks between two looks at whether the observer rests; most looks; the angles' motion at which it does [rad]."""


class ChainStep(NamedTuple):
    """x' = A x + B_u u + B_p p + B_v v of deviations; x (2N,) is angles [rad] before rates [rad/s]."""

    A: Array
    """(2N,2N)."""
    B_u: Array
    """By the torques u (2N,2)."""
    B_p: Array
    """By the measured points of the m springs, x then y of each (2N,2m)."""
    B_v: Array
    """By their measured velocities (2N,2m)."""
    P: Array
    """The m points by the state x, in the same order (2m,2N)."""


def draw(observer: Observer, used: tuple[int, ...], measured: Array, u: Array, gains: tuple[float, float]) -> None:
    """Let the sensors `used`, counted from 0, be drawn to `measured` (10,2) [m] by K_o and B_o, under u (2,) [N m].

    Eq. OBS: paper, "Dynamic observer". In place: observer.
    """
    springs, bits = observer.load.springs, sum(1 << sensor for sensor in used)
    springs.K[:], springs.B[:] = gains
    attach(measured, np.zeros_like(measured), 0.0, bits, observer)
    damp_beyond(bits, observer)
    observer.torque[:], observer.level[:] = u, np.abs(u)
    pressurise(observer)


def rest_of(observer: Observer) -> Array:
    """Angles (N,) in which the observer comes to rest from where it is, under its load. In place: observer.state."""
    for _ in range(RESTS):
        before = observer.state.q[2].copy()
        rest(observer, TICKS)
        if np.abs(observer.state.q[2] - before).max() < STILL:
            break
    return np.array(observer.state.q[2])


@compiled
def rest(observer: Observer, ticks: int) -> None:
    """`ticks` steps of the observer under its load. In place: observer."""
    for _ in range(ticks):
        step_observer(observer)


def observer_step(observer: Observer, theta: Array) -> ChainStep:
    """A tick of `observer` about the pose theta (N,) in which it rests under the load that it has.

    In place: observer.
    """
    model, springs, rods = observer.model, observer.load.springs, theta.size
    count = int(springs.active[0])
    measured, torque = springs.anchor[:count].copy(), observer.load.Q_theta.copy()
    T_theta = model.T_theta - stiffer(model, observer.unpressed.k, theta, observer.torque)

    def after(deviation: Array) -> Array:
        x, u, p, v = np.split(deviation, np.cumsum([2 * rods, 2, 2 * count]))
        move(model, theta, x, observer.state)
        observer.load.Q_theta[:] = torque + T_theta @ u
        springs.anchor[:count] = measured + p.reshape(count, 2)
        springs.rate[:count] = v.reshape(count, 2)
        step_observer(observer)
        return np.concatenate([observer.state.q[2] - theta, observer.state.v[2]])

    D = slopes(after, 2 * rods + 2 + 4 * count)
    A, B_u, B_p, B_v = np.split(D, np.cumsum([2 * rods, 2, 2 * count]), axis=1)
    return ChainStep(A, B_u, B_p, B_v, by_state(model, theta, Places(springs.rod[:count], springs.offset[:count])))


def free_step(observer: Observer, theta: Array, used: tuple[int, ...]) -> ChainStep:
    """A tick of the model that the torques alone move, about its static pose theta (N,) under those that it has.

    In place: observer.prediction.
    """
    prediction = observer.prediction
    model, load = prediction.model, prediction.load
    T_theta = model.T_theta - stiffer(model, observer.unpressed.k, theta, observer.torque)
    balance = holding(model, theta)

    def step(more: Array) -> None:
        load.Q_theta[:] = balance + T_theta @ more
        implicit_step(model, load, observer.dt, prediction.state, observer.implicit_work)

    P = by_state(model, theta, chosen(observer.sensors, used))
    return driven_step(model, theta, prediction.state, step, P)


def plant_step(twin: Twin, u: Array, used: tuple[int, ...]) -> tuple[ChainStep, Array]:
    """A tick of the twin's chain about its static pose under u (2,) [N m]; the markers (10,2) [m].

    Without friction, creep and hysteresis, which damp. In place: twin.
    """
    model, rods, state, load = twin.model, twin.model.L.size, twin.state, twin.load
    gain = (twin.chambers.torque_per_pascal / twin.torque_per_pascal)[::2]
    press_chain(abs(u[0]), abs(u[1]), twin.unpressed, model, twin.markers, twin.backbone)
    theta = settled(model, model.T_theta @ (gain * u))
    T_theta = model.T_theta * gain - stiffer(model, twin.unpressed.k, theta, u)
    balance = holding(model, theta)
    load.F[:] = 0.0

    def step(more: Array) -> None:
        load.Q_theta[:] = balance + T_theta @ more
        if twin.integrator == Integrator.IMPLICIT:
            implicit_step(model, load, twin.dt, state, twin.implicit_work)
        else:
            for _ in range(twin.substeps):
                rk4_step(model, load, twin.dt / twin.substeps, state, twin.work)

    found = driven_step(model, theta, state, step, by_state(model, theta, chosen(twin.markers, used)))
    move(model, theta, np.zeros(2 * rods), state)
    markers = np.zeros((SENSORS, 2))
    points_on(state.q, twin.markers, markers)
    return found, markers


def driven_step(model: RodModel, theta: Array, state: RodState, step: Callable[[Array], None], P: Array) -> ChainStep:
    """A tick of a chain that torques move, about theta (N,): `step` advances `state` with more of them (2,) [N m].

    In place: state.
    """
    rods = theta.size

    def after(deviation: Array) -> Array:
        x, more = np.split(deviation, [2 * rods])
        move(model, theta, x, state)
        step(more)
        return np.concatenate([state.q[2] - theta, state.v[2]])

    D, nothing = slopes(after, 2 * rods + 2), np.zeros((2 * rods, 0))
    return ChainStep(D[:, : 2 * rods], D[:, 2 * rods :], nothing, nothing, P)


def stiffer(model: RodModel, soft: Array, theta: Array, u: Array) -> Array:
    """Torques (N,2) per u that hinges of `soft` (N,) resist more in the pose theta (N,), by the pressures of u (2,)."""
    if not model.stiffening.size:
        return np.zeros((theta.size, 2))
    bend = np.diff(theta, prepend=0.0) - model.bend
    more = (soft * bend)[:, None] * model.stiffening * np.sign(u)
    return np.asarray(more - np.concatenate([more[1:], np.zeros((1, 2))]))


def largest_modulus(A: Array) -> float:
    """Of the eigenvalues of A (n,n)."""
    if A.shape[0] <= DENSE:
        return float(np.abs(np.linalg.eigvals(A)).max())
    from scipy.sparse.linalg import eigs

    start = np.random.default_rng(0).normal(size=A.shape[0])
    return float(np.abs(eigs(A, 4, v0=start, ncv=60, tol=1e-9, return_eigenvectors=False)).max())


def slopes(after: Callable[[Array], Array], size: int) -> Array:
    """Derivative of `after` by each of `size` deviations, as columns."""
    rows = DEVIATION * np.eye(size)
    return np.array([(after(row) - after(-row)) / (2.0 * DEVIATION) for row in rows]).T


def holding(model: RodModel, theta: Array) -> Array:
    """Torques (N,) [N m] under which the chain rests in the pose theta: springs less gravity."""
    return -imbalance(model, theta)


def settled(model: RodModel, torque: Array) -> Array:
    """Angles (N,) in which the chain rests under torques on its angles (N,) [N m]."""
    return settle(carrying(body_of(model), torque), model.rest)


def by_state(model: RodModel, theta: Array, at: Places) -> Array:
    """Derivatives of the points `at` (m) by angles and rates (2m,2N) [m/rad], x then y of each."""
    J = point_slopes(model, theta, at)
    return np.concatenate([J, np.zeros_like(J)], axis=1)
