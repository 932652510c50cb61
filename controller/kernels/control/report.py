"""The telemetry row: what this tick sensed, estimated, wanted and sent."""

import math

from controller.arrays import Record
from controller.kernels.compiled import kernel
from controller.kernels.memory import Control, Sensing
from controller.kernels.model.pneumatics import chamber_pressures
from controller.kernels.model.statics import points_on, tip_of
from controller.kernels.observer.observer import Observer, residual


@kernel
def report_estimate(
    control: Control, sensing: Sensing, t_ns: int, measurement: Record, observer: Observer, out_telemetry: Record
) -> None:
    """Markers, measured tip, observer's tip and backbone, residual.

    Not in the paper: telemetry. In place: observer.points.
    """
    state = control.state[0]
    old_ns = control.limits[0].measurement_old * 1e9
    fresh = sensing.sample_ns[0] > 0 and t_ns - sensing.sample_ns[0] <= old_ns
    last = sensing.p.shape[0] - 1
    for j in range(2):
        for i in range(last + 1):
            out_telemetry.markers[i, j] = sensing.p[i, j] if fresh else math.nan
        out_telemetry.p_meas[j] = out_telemetry.markers[last, j]
    out_telemetry.p_hat[0], out_telemetry.p_hat[1] = tip_of(observer.model, observer.state.q)
    out_telemetry.residual = residual(sensing, state.used, observer)
    points_on(observer.state.q, observer.backbone, out_telemetry.backbone)
    for j in range(4):
        out_telemetry.pressure_meas[j] = measurement.pressures[j]
    for j in range(2):
        out_telemetry.u_hat[j] = observer.u_hat[j]
    for j in range(4):
        out_telemetry.power[j] = observer.ledger.power[j]
    out_telemetry.energy = observer.ledger.energy[0]
    out_telemetry.ledger = observer.ledger.energy[0] - observer.ledger.given[0]
    out_telemetry.sensed = state.used
    out_telemetry.measurement_age = (t_ns - max(state.seen_ns, state.start_ns if state.seen_ns == 0 else 0)) * 1e-9


@kernel
def report_command(control: Control, command: Record, out_telemetry: Record) -> None:
    """Target, reference, torques and chamber setpoints (paper, "Controller Architecture")."""
    state, wanted = control.state[0], control.slot.wanted[0]
    for j in range(2):
        out_telemetry.target[j] = command.target[j]
        out_telemetry.p_ref[j] = state.p_ref[j]
        out_telemetry.p_ref_dot[j] = state.p_ref_dot[j]
        out_telemetry.integral[j] = wanted.integral[j]
        out_telemetry.u_ff[j] = state.u_ff[j]
        out_telemetry.u_fb[j] = state.u_fb[j]
        out_telemetry.u[j] = state.u[j]
    out_telemetry.reachable = state.reachable
    out_telemetry.law, out_telemetry.controller = command.settings.law, state.controller
    for j in range(wanted.signals.size):
        out_telemetry.signals[j] = wanted.signals[j]
    chamber_pressures(state.u, control.pascal_per_torque, out_telemetry.pressure_cmd)


@kernel
def report_loop(t_ns: int, command: Record, status: Record, control: Control, out_telemetry: Record) -> None:
    """Mode, requests, ages and what the loop knows of itself; counts the tick.

    Not in the paper: telemetry. In place: control.state.tick.
    """
    state = control.state[0]
    out_telemetry.tick = state.tick
    out_telemetry.t_ns = t_ns
    out_telemetry.mode, out_telemetry.cause = state.mode, state.cause
    out_telemetry.command_n = command.n
    out_telemetry.request_n, out_telemetry.request_cause = state.request_n, state.request_cause
    out_telemetry.presence = state.presence
    out_telemetry.operator_age = (t_ns - max(state.presence_ns, state.start_ns)) * 1e-9
    out_telemetry.server_age = (t_ns - max(status.server_ns, state.start_ns)) * 1e-9
    out_telemetry.lost, out_telemetry.lateness_ns, out_telemetry.step_ns = (
        status.lost,
        status.lateness_ns,
        status.step_ns,
    )
    state.tick += 1
