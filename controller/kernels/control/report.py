"""The telemetry row: what this tick sensed, estimated, wanted and sent."""

import math

from controller.kernels.compiled import kernel
from controller.kernels.model.pneumatics import chamber_pressures
from controller.kernels.model.statics import points_on, tip_of
from controller.kernels.observer.observer import residual


@kernel
def report_estimate(control, observer, sensing, t_ns, measurement, telemetry):
    """Markers, measured tip, observer's tip and backbone, residual."""
    state = control.state[0]
    old_ns = control.limits[0].measurement_old * 1e9
    fresh = sensing.sample_ns[0] > 0 and t_ns - sensing.sample_ns[0] <= old_ns
    last = sensing.p.shape[0] - 1
    for j in range(2):
        for i in range(last + 1):
            telemetry.markers[i, j] = sensing.p[i, j] if fresh else math.nan
        telemetry.p_meas[j] = telemetry.markers[last, j]
    telemetry.p_hat[0], telemetry.p_hat[1] = tip_of(observer.model, observer.state.q)
    telemetry.residual = residual(sensing, state.used, observer)
    points_on(observer.state.q, observer.backbone, telemetry.backbone)
    for j in range(4):
        telemetry.pressure_meas[j] = measurement.pressures[j]
    for j in range(2):
        telemetry.u_hat[j] = observer.u_hat[j]
    for j in range(4):
        telemetry.power[j] = observer.ledger.power[j]
    telemetry.energy = observer.ledger.energy[0]
    telemetry.ledger = observer.ledger.energy[0] - observer.ledger.given[0]
    telemetry.sensed = state.used
    telemetry.measurement_age = (t_ns - max(state.seen_ns, state.start_ns if state.seen_ns == 0 else 0)) * 1e-9


@kernel
def report_command(control, command, telemetry):
    """Target, reference, torques and chamber setpoints."""
    state = control.state[0]
    for j in range(2):
        telemetry.target[j] = command.target[j]
        telemetry.p_ref[j] = state.p_ref[j]
        telemetry.p_ref_dot[j] = state.p_ref_dot[j]
        telemetry.integral[j] = state.integral[j]
        telemetry.u_ff[j] = state.u_ff[j]
        telemetry.u_fb[j] = state.u_fb[j]
        telemetry.u[j] = state.u[j]
    telemetry.reachable = state.reachable
    telemetry.law = command.settings.law
    chamber_pressures(state.u, control.pascal_per_torque, telemetry.pressure_cmd)


@kernel
def report_loop(control, t_ns, command, status, telemetry):
    """Mode, requests, ages and what the loop knows of itself; counts the tick."""
    state = control.state[0]
    telemetry.tick = state.tick
    telemetry.t_ns = t_ns
    telemetry.mode, telemetry.cause = state.mode, state.cause
    telemetry.command_n = command.n
    telemetry.request_n, telemetry.request_cause = state.request_n, state.request_cause
    telemetry.presence = state.presence
    telemetry.operator_age = (t_ns - max(state.presence_ns, state.start_ns)) * 1e-9
    telemetry.server_age = (t_ns - max(status.server_ns, state.start_ns)) * 1e-9
    telemetry.lost, telemetry.lateness_ns, telemetry.step_ns = status.lost, status.lateness_ns, status.step_ns
    state.tick += 1
