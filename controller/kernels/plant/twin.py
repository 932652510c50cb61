"""The twin: a simulated actuator that stands in for the hardware, with its flaws.

A finer chain than the controller's model, stiffness and torque gain scaled together, creep and hysteresis, friction on
the sheet, four chambers behind valves and air lines, and noisy markers at 100 Hz that arrive late.
"""

import math

from controller.arrays import Array, Record, Seed, Words
from controller.kernels.compiled import kernel
from controller.kernels.group import Group
from controller.kernels.model.friction import Hysteresis, Sheet, resist_hysteresis, rub
from controller.kernels.model.implicit import ImplicitWork, implicit_step
from controller.kernels.model.integrate import rk4_step
from controller.kernels.model.pressed import Unpressed, close_up, is_pressed, press_chain
from controller.kernels.model.rod import Load, RodModel, RodState, Work
from controller.kernels.model.statics import Places, points_on
from controller.kernels.plant.camera import NO_SAMPLE, Camera, deliver, expose, open_slot
from controller.kernels.plant.faults import Faults
from controller.kernels.plant.valve import Chambers, dump, fill_chambers
from controller.kernels.safety.safety import E_STOP
from controller.schema.modes import Integrator


class Creep(Group):
    """Two Maxwell branches beside every hinge's spring."""

    share: Array
    """Branch stiffness over hinge stiffness (2,)."""
    time: Array
    """Relaxation times (2,) [s]."""
    relaxed: Array
    """Bend at which each branch carries no torque (2,N) [rad]."""


class Twin(Group):
    """The plant and its memory; built by `build_twin`."""

    model: RodModel
    state: RodState
    load: Load
    work: Work
    """Scratch of RK4."""
    integrator: int
    creeping: RodModel
    """For the implicit step: with the branches of the creep in the stiffness of the hinges, as they are for a step."""
    implicit_work: ImplicitWork
    dt: float
    """Period of the loop [s]."""
    substeps: int
    unpressed: Unpressed
    torque_per_pascal: Array
    """Of each chamber in the model's units (4,) [N m/Pa]: by it pressures make the levels of `under_levels`."""
    sheet: Sheet
    creep: Creep
    hysteresis: Hysteresis
    chambers: Chambers
    camera: Camera
    faults: Faults
    markers: Places
    """Of the camera (10)."""
    backbone: Places
    """The telemetry's backbone points (21)."""
    ticks: Words
    """(1,) steps made."""
    seed: Seed
    """(1,) state of the noise."""


@kernel
def twin_step(t_ns: int, twin: Twin, telemetry: Record, out_measurement: Record) -> None:
    """Show the plant as it is at t_ns [ns], then advance it by dt under telemetry.pressure_cmd; E_STOP dumps the air.

    Sets out_measurement.pressures and, when a sample is due, its markers and their capture time. Not in the paper,
    whose plant is the hardware ("Experimental Platform"). In place: twin, telemetry.twin_backbone.
    """
    points_on(twin.state.q, twin.backbone, telemetry.twin_backbone)
    slot = open_slot(t_ns, twin.ticks[0], twin.faults, twin.camera)
    if slot != NO_SAMPLE:
        points_on(twin.state.q, twin.markers, twin.camera.points[slot])
        expose(slot, twin.faults, twin.camera, twin.seed)
    deliver(twin.camera, twin.ticks[0], out_measurement)
    if telemetry.mode == E_STOP:
        dump(twin.dt, twin.chambers)
    fill_chambers(twin.ticks[0], telemetry.pressure_cmd, twin.dt, twin.chambers)
    if is_pressed(twin.model):
        press_twin(twin)
    h = twin.dt / twin.substeps
    for _ in range(twin.substeps):
        press(twin.model, twin.chambers, twin.load.Q_theta)
        resist_creep(twin.model, twin.state.q, h, twin.creep, twin.load.Q_theta)
        resist_hysteresis(twin.model, twin.state.q, twin.hysteresis, twin.load.Q_theta)
        rub(twin.model.m, twin.state.v, h, twin.sheet, twin.load.F)
        if twin.integrator == Integrator.IMPLICIT:
            free_creep(twin.model, twin.state.q, twin.creep, twin.load.Q_theta)
            implicit_step(twin.creeping, twin.load, h, twin.state, twin.implicit_work)
        else:
            rk4_step(twin.model, twin.load, h, twin.state, twin.work)
    for j in range(4):
        out_measurement.pressures[j] = twin.chambers.sensed[j]
    twin.ticks[0] += 1


@kernel
def press_twin(twin: Twin) -> None:
    """Stiffness of the hinges, and with the branches of the creep, and lengths under the chambers' pressures.

    Not in the paper, where no pressure changes them. In place: twin.model, twin.creeping.k, twin.state.q.
    """
    p, per, creep = twin.chambers.pressure, twin.torque_per_pascal, twin.creep.share[0] + twin.creep.share[1]
    level_1, level_2 = per[0] * p[0] + per[1] * p[1], per[2] * p[2] + per[3] * p[3]
    press_chain(level_1, level_2, twin.unpressed, twin.model, twin.markers, twin.backbone)
    close_up(twin.model, twin.state.q)
    for i in range(twin.creeping.k.size):
        twin.creeping.k[i] = twin.model.k[i] * (1.0 + creep)


@kernel
def press(model: RodModel, chambers: Chambers, out_Q_theta: Array) -> None:
    """Torques (N,) [N m] of the differential pressures (paper, "Controller Architecture")."""
    p, per = chambers.pressure, chambers.torque_per_pascal
    u1 = per[0] * p[0] - per[1] * p[1]
    u2 = per[2] * p[2] - per[3] * p[3]
    for i in range(out_Q_theta.size):
        out_Q_theta[i] = model.T_theta[i, 0] * u1 + model.T_theta[i, 1] * u2


@kernel
def resist_creep(model: RodModel, q: Array, h: float, creep: Creep, Q_theta: Array) -> None:
    """Torques of the Maxwell branches; they relax towards the present bend of q (3,N) for h [s].

    Not in the paper: a flaw of the twin. In place: creep.relaxed, Q_theta (N,) [N m], to which they are added.
    """
    for branch in range(2):
        keep = math.exp(-h / creep.time[branch])
        for i in range(Q_theta.size):
            bend = q[2, i] - q[2, i - 1] if i > 0 else q[2, 0]
            stretch = bend - creep.relaxed[branch, i]
            creep.relaxed[branch, i] = bend - keep * stretch
            torque = creep.share[branch] * model.k[i] * stretch
            Q_theta[i] -= torque
            if i > 0:
                Q_theta[i - 1] += torque


@kernel
def free_creep(model: RodModel, q: Array, creep: Creep, Q_theta: Array) -> None:
    """Take off the torque that the branches of Twin.creeping add to the hinges' springs in the pose q (3,N).

    What `resist_creep` adds is held for a step. With this, and the branches' stiffness in the model that takes it, the
    same torque begins the step and follows its motion: held, a branch stiffer than the hinge would throw fast modes
    out. Not in the paper: a flaw of the twin. In place: Q_theta (N,) [N m].
    """
    share = creep.share[0] + creep.share[1]
    for i in range(Q_theta.size):
        bend = q[2, i] - q[2, i - 1] if i > 0 else q[2, 0]
        torque = share * model.k[i] * (bend - model.bend[i])
        Q_theta[i] += torque
        if i > 0:
            Q_theta[i - 1] -= torque
