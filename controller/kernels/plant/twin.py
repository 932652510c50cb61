"""The twin: a simulated actuator that stands in for the hardware, with its flaws (PHYSICS.md, "the twin").

A finer chain than the controller's model, stiffness and torque gain scaled together, creep and hysteresis, friction on
the sheet, four chambers behind valves and air lines, and noisy markers at 100 Hz that arrive late.
"""

import math
from typing import NamedTuple

import numpy as np

from controller.arrays import Array
from controller.kernels.compiled import kernel
from controller.kernels.model.friction import Hysteresis, Sheet, resist_hysteresis, rub
from controller.kernels.model.integrate import rk4_step
from controller.kernels.model.rod import Load, RodModel, RodState, Work
from controller.kernels.model.statics import Places, points_on
from controller.kernels.plant.faults import LOST, Faults, sample_lost, spoil
from controller.kernels.plant.noise import normal_pair
from controller.kernels.plant.valve import Chambers, dump, fill_chambers
from controller.kernels.safety.safety import E_STOP
from controller.schema.modes import Freeze

FREEZE_OFF, FRESH_TIME = int(Freeze.OFF), int(Freeze.FRESH_TIME)


class Creep(NamedTuple):
    """Two Maxwell branches beside every hinge's spring."""

    share: Array
    """Branch stiffness over hinge stiffness (2,)."""
    time: Array
    """Relaxation times (2,) [s]."""
    relaxed: Array
    """Bend at which each branch carries no torque (2,N) [rad]."""


class Camera(NamedTuple):
    """Motion capture of the markers; samples wait here until they are due."""

    markers: Places
    noise: float
    """Standard deviation of each coordinate [m]."""
    period: int
    """Ticks between samples."""
    latency: int
    """Ticks from capture to delivery."""
    t_ns: np.ndarray
    """(n,) time of capture; LOST: this sample is never delivered."""
    points: Array
    """(n,10,2) [m]."""


class Twin(NamedTuple):
    """The plant and its memory; built by `build_twin`."""

    model: RodModel
    state: RodState
    load: Load
    work: Work
    dt: float
    """Period of the loop [s]."""
    substeps: int
    sheet: Sheet
    creep: Creep
    hysteresis: Hysteresis
    chambers: Chambers
    camera: Camera
    faults: Faults
    backbone: Places
    """The telemetry's backbone points (21)."""
    ticks: np.ndarray
    """(1,) steps made."""
    seed: np.ndarray
    """(1,) uint64 state of the noise."""


@kernel
def twin_step(twin, t_ns, telemetry, measurement):
    """Show the plant as it is at t_ns [ns], then advance it by dt under telemetry.pressure_cmd; E_STOP dumps the air.

    Writes telemetry.twin_backbone, measurement.pressures and, when a sample is due, the markers and their capture time.
    """
    points_on(twin.state.q, twin.backbone, telemetry.twin_backbone)
    capture(twin, t_ns)
    deliver(twin.camera, twin.ticks[0], measurement)
    if telemetry.mode == E_STOP:
        dump(twin.chambers, twin.dt)
    fill_chambers(twin.chambers, twin.ticks[0], telemetry.pressure_cmd, twin.dt)
    h = twin.dt / twin.substeps
    for _ in range(twin.substeps):
        press(twin.model, twin.chambers, twin.load)
        resist_creep(twin.model, twin.creep, twin.state.q, twin.load, h)
        resist_hysteresis(twin.model, twin.state.q, twin.hysteresis, twin.load.Q_theta)
        rub(twin.model, twin.state.v, h, twin.sheet, twin.load.F)
        rk4_step(twin.model, twin.load, h, twin.state, twin.work)
    for j in range(4):
        measurement.pressures[j] = twin.chambers.sensed[j]
    twin.ticks[0] += 1


@kernel
def capture(twin, t_ns):
    """Take a noisy sample of all markers if one is due."""
    camera = twin.camera
    if twin.ticks[0] % camera.period != 0:
        return
    slot = twin.ticks[0] // camera.period % camera.t_ns.size
    if twin.faults.freeze[0] != FREEZE_OFF:
        repeat(camera, slot, t_ns if twin.faults.freeze[0] == FRESH_TIME else LOST)
        return
    camera.t_ns[slot] = t_ns
    points = camera.points[slot]
    points_on(twin.state.q, camera.markers, points)
    for i in range(points.shape[0]):
        x, y = normal_pair(twin.seed)
        points[i, 0] += camera.noise * x
        points[i, 1] += camera.noise * y
    if sample_lost(twin.faults):
        camera.t_ns[slot] = LOST
    spoil(twin.faults, points)


@kernel
def repeat(camera, slot, t_ns):
    """Put the sample taken last into `slot` under another time of capture; LOST: it says nothing new."""
    last = (slot - 1) % camera.t_ns.size
    camera.t_ns[slot] = t_ns
    for i in range(camera.points.shape[1]):
        for j in range(2):
            camera.points[slot, i, j] = camera.points[last, i, j]


@kernel
def deliver(camera, tick, measurement):
    """Hand over the sample whose latency has passed in this tick."""
    taken = tick - camera.latency
    if taken < 0 or taken % camera.period != 0:
        return
    slot = taken // camera.period % camera.t_ns.size
    if camera.t_ns[slot] == LOST:
        return
    measurement.t_ns = camera.t_ns[slot]
    for i in range(camera.points.shape[1]):
        for j in range(2):
            measurement.markers[i, j] = camera.points[slot, i, j]


@kernel
def press(model, chambers, load):
    """Torques of the differential pressures, into the load."""
    p = chambers.pressure
    u1 = chambers.torque_per_pascal[0] * (p[0] - p[1])
    u2 = chambers.torque_per_pascal[1] * (p[2] - p[3])
    for i in range(load.Q_theta.size):
        load.Q_theta[i] = model.T_theta[i, 0] * u1 + model.T_theta[i, 1] * u2


@kernel
def resist_creep(model, creep, q, load, h):
    """Torques of the Maxwell branches, added to the load; the branches relax towards the present bend for h [s]."""
    for branch in range(2):
        keep = math.exp(-h / creep.time[branch])
        for i in range(load.Q_theta.size):
            bend = q[2, i] - q[2, i - 1] if i > 0 else q[2, 0]
            stretch = bend - creep.relaxed[branch, i]
            creep.relaxed[branch, i] = bend - keep * stretch
            torque = creep.share[branch] * model.k[i] * stretch
            load.Q_theta[i] -= torque
            if i > 0:
                load.Q_theta[i - 1] += torque
