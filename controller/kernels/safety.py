"""Safety states and watchdogs: the transition table as data, one function for each line of the watchdog table.

Every age is taken on the loop's own clock; silence while the loop itself stood still is not held against anyone.
"""

import math

import numpy as np

from controller.kernels.compiled import kernel
from controller.modes import Cause, Mode, Request

VENTED, HOLD, FOLLOW, TRACK, REST, FAULT, E_STOP = (int(mode) for mode in Mode)
REFUSED = -1
R = REFUSED
#    NONE    ARM   HOLD  FOLLOW  TRACK  REST  CLEAR   E_STOP
TRANSITIONS = np.array(
    [
        [VENTED, HOLD, R, R, R, R, R, E_STOP],  # VENTED
        [HOLD, R, HOLD, FOLLOW, TRACK, REST, R, E_STOP],  # HOLD
        [FOLLOW, R, HOLD, FOLLOW, R, REST, R, E_STOP],  # FOLLOW
        [TRACK, R, HOLD, FOLLOW, R, REST, R, E_STOP],  # TRACK
        [REST, R, HOLD, R, R, REST, R, E_STOP],  # REST
        [FAULT, R, R, R, R, R, VENTED, E_STOP],  # FAULT
        [E_STOP, R, R, R, R, R, VENTED, E_STOP],  # E_STOP
    ]
)
"""Mode after [mode, request], or REFUSED."""

ASK_ARM, ASK_CLEAR, ASK_E_STOP = int(Request.ARM), int(Request.CLEAR), int(Request.E_STOP)
NO_CAUSE, OPERATOR, OPERATOR_LOST = int(Cause.NONE), int(Cause.OPERATOR), int(Cause.OPERATOR_LOST)
SERVER_LOST, PUMP_LOST, MEASUREMENT_LOST = int(Cause.SERVER_LOST), int(Cause.PUMP_LOST), int(Cause.MEASUREMENT_LOST)
LOOP_STALLED, NOT_FINITE, PRESSURE = int(Cause.LOOP_STALLED), int(Cause.NOT_FINITE), int(Cause.PRESSURE)
TRACKING_ERROR, RESTED, WRONG_MODE = int(Cause.TRACKING_ERROR), int(Cause.RESTED), int(Cause.WRONG_MODE)
WRONG_BOOT, NO_REFERENCE, NO_OPERATOR = int(Cause.WRONG_BOOT), int(Cause.NO_REFERENCE), int(Cause.NO_OPERATOR)


@kernel
def supervise(control, t_ns, command, status, measurement):
    """Act on a new request, then let every watchdog look: sets mode and cause for this tick (DESIGN section 5)."""
    state, limits = control.state[0], control.limits[0]
    before = state.mode
    if command.presence > state.presence:  # a rise: a second server that repeats another number is no operator
        state.presence, state.presence_ns = command.presence, t_ns
    if command.request_n > state.request_n:
        consider(control, t_ns, command)
    watch_loop(state, limits, t_ns)
    watch_operator(state, limits, t_ns)
    watch_link(state, limits.server_hold, limits.server_rest, silence(state, status.server_ns, t_ns), SERVER_LOST)
    watch_link(state, limits.pump_hold, limits.pump_rest, silence(state, status.pump_ns, t_ns), PUMP_LOST)
    watch_measurement(state, limits, t_ns)
    watch_error(state, limits)
    watch_numbers(control, command)
    watch_pressure(state, limits, measurement)
    if state.mode == REST and state.u[0] == 0.0 and state.u[1] == 0.0:
        move(state, VENTED, RESTED)
    state.entered = state.mode != before
    state.last_ns = t_ns


@kernel
def move(state, mode, cause):
    """Change the mode and say why."""
    state.mode = mode
    state.cause = cause


@kernel
def is_live(mode):
    """HOLD, FOLLOW or TRACK: the reference rules u."""
    return mode == HOLD or mode == FOLLOW or mode == TRACK


@kernel
def is_moving(mode):
    """FOLLOW or TRACK: the reference itself may move."""
    return mode == FOLLOW or mode == TRACK


@kernel
def silence(state, seen_ns, t_ns):
    """Seconds since `seen_ns`, or since the start, without those of the loop's last stall."""
    since_ns = max(seen_ns, state.start_ns)
    stalled_ns = max(0, state.resume_ns - max(since_ns, state.stall_ns))
    return (t_ns - since_ns - stalled_ns) * 1e-9


@kernel
def present(state, limits, t_ns):
    """Whether an operator has shown presence within the timeout."""
    return state.presence_ns > 0 and (t_ns - state.presence_ns) * 1e-9 <= limits.operator_timeout


@kernel
def consider(control, t_ns, command):
    """Accept or refuse the request of `command`, once; after a CLEAR the observer starts anew."""
    state, request = control.state[0], command.request
    wanted = TRANSITIONS[state.mode, request] if 0 <= request < TRANSITIONS.shape[1] else REFUSED
    state.request_n = command.request_n
    state.request_cause = NO_CAUSE
    if request != ASK_E_STOP and command.boot != state.boot:
        state.request_cause = WRONG_BOOT
    elif wanted == REFUSED:
        state.request_cause = WRONG_MODE
    elif wanted == TRACK and state.mode != TRACK and control.plan[0].rows == 0:
        state.request_cause = NO_REFERENCE
    elif request != 0 and is_moving(wanted) and not present(state, control.limits[0], t_ns):
        state.request_cause = NO_OPERATOR
    elif request != 0:
        state.unattended = command.unattended
        move(state, wanted, OPERATOR)
        state.forget = request == ASK_CLEAR


@kernel
def watch_loop(state, limits, t_ns):
    """The loop itself stood still: HOLD on resume."""
    if (t_ns - state.last_ns) * 1e-9 > limits.loop_gap:
        state.stall_ns, state.resume_ns = state.last_ns, t_ns
        if is_moving(state.mode):
            move(state, HOLD, LOOP_STALLED)


@kernel
def watch_operator(state, limits, t_ns):
    """No operator in a moving mode: HOLD, unless a TRACK run was started as unattended."""
    alone = state.mode == TRACK and state.unattended != 0
    if is_moving(state.mode) and not alone and not present(state, limits, t_ns):
        move(state, HOLD, OPERATOR_LOST)


@kernel
def watch_link(state, hold_after, rest_after, silent, cause):
    """Server or pump silent: HOLD, after a longer time ramp to rest."""
    if is_live(state.mode) and silent > rest_after:
        move(state, REST, cause)
    elif is_moving(state.mode) and silent > hold_after:
        move(state, HOLD, cause)


@kernel
def watch_measurement(state, limits, t_ns):
    """No usable marker for long: FAULT, ramp to rest. (For less long, `sense` already took the feedback off.)"""
    if is_live(state.mode) and silence(state, state.seen_ns, t_ns) > limits.measurement_lost:
        move(state, FAULT, MEASUREMENT_LOST)


@kernel
def watch_error(state, limits):
    """Tracking error above its limit for its time, in closed loop with the target in reach: FAULT."""
    if is_live(state.mode) and state.off_time > limits.error_time:
        move(state, FAULT, TRACKING_ERROR)


@kernel
def watch_numbers(control, command):
    """A number in the command or in the estimated state is not finite: E_STOP."""
    state, q, v = control.state[0], control.q, control.v
    total = command_sum(command)
    for row in range(3):
        for i in range(q.shape[1]):
            total += q[row, i] + v[row, i]
    if state.mode != E_STOP and not state.forget and not math.isfinite(total):
        move(state, E_STOP, NOT_FINITE)


@kernel
def command_sum(command):
    """Sum of every real number in the command: not finite if one of them is not."""
    s = command.settings
    total = s.feedforward_period + s.speed_max + s.acceleration_max
    for j in range(2):
        total += command.target[j] + s.K_P[j] + s.K_I[j] + s.K_FF[j] + s.K_o[j] + s.B_o[j] + s.u_open[j]
    return total


@kernel
def watch_pressure(state, limits, measurement):
    """A chamber pressure is too high or not a number: E_STOP."""
    for j in range(measurement.pressures.shape[0]):
        if state.mode != E_STOP and not measurement.pressures[j] <= limits.pressure_max:
            move(state, E_STOP, PRESSURE)
