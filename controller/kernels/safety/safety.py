"""Safety states and watchdogs in the loop: they act by the tables of controller/schema/states.py (docs/safety.md).

Every age is taken on the loop's own clock; silence while the loop itself stood still is not held against anyone.
"""

import math

import numpy as np

from controller.arrays import Array, Record
from controller.kernels.compiled import kernel
from controller.kernels.memory import Control
from controller.kernels.safety.chamber_watch import chambers_broken, chambers_follow, note_chambers
from controller.schema.modes import Cause, Mode, Request
from controller.schema.states import DRIVEN, KEPT, LIVE, MOVING, WATCHDOGS, Watch, next_mode

VENTED, HOLD, FOLLOW, TRACK, REST, FAULT, E_STOP = (int(mode) for mode in Mode)
REFUSED = -1


def _refusable(mode: Mode, request: Request) -> int:
    wanted = next_mode(mode, request)
    return REFUSED if wanted is None else int(wanted)


def _bits(members: tuple[Mode, ...] | tuple[Cause, ...]) -> int:
    return sum(1 << member for member in members)


TRANSITIONS = np.array([[_refusable(mode, request) for request in Request] for mode in Mode])
"""Mode after [mode, request], or REFUSED."""
WATCHED_IN = np.array([_bits(WATCHDOGS[watch].modes) for watch in Watch])
REACTION = np.array([int(WATCHDOGS[watch].reaction) for watch in Watch])
CAUSE = np.array([int(WATCHDOGS[watch].cause) for watch in Watch])
LIVE_BITS, MOVING_BITS, DRIVEN_BITS, KEPT_BITS = _bits(LIVE), _bits(MOVING), _bits(DRIVEN), _bits(KEPT)

LOOP, OPERATOR_SIGN, SERVER_SILENT, SERVER_GONE = (int(watch) for watch in list(Watch)[:4])
PUMP_SILENT, PUMP_GONE = int(Watch.PUMP_SILENT), int(Watch.PUMP_GONE)
MARKERS_LOST, MARKERS_JUMPED = int(Watch.MARKERS_LOST), int(Watch.MARKERS_JUMPED)
MARKERS_FROZEN, ERROR, ERROR_RMS = int(Watch.MARKERS_FROZEN), int(Watch.ERROR), int(Watch.ERROR_RMS)
OSCILLATION, RESIDUAL, SPEED = int(Watch.OSCILLATION), int(Watch.RESIDUAL), int(Watch.SPEED)
FLOW, NUMBERS, PRESSURE = int(Watch.FLOW), int(Watch.NUMBERS), int(Watch.PRESSURE)
PRESSURES_LOST = int(Watch.PRESSURES_LOST)

ASK_CLEAR, ASK_E_STOP = int(Request.CLEAR), int(Request.E_STOP)
NO_CAUSE, OPERATOR, RESTED = int(Cause.NONE), int(Cause.OPERATOR), int(Cause.RESTED)
WRONG_MODE, WRONG_BOOT = int(Cause.WRONG_MODE), int(Cause.WRONG_BOOT)
NO_REFERENCE, NO_OPERATOR = int(Cause.NO_REFERENCE), int(Cause.NO_OPERATOR)


@kernel
def supervise(t_ns: int, command: Record, status: Record, measurement: Record, u_hat: Array, control: Control) -> None:
    """Act on a new request, then let every watchdog look: sets mode and cause for this tick.

    `u_hat` (2,) [N m] is what the model believes to be in the chambers. Not in the paper.
    In place: control.state.
    """
    state, limits = control.state[0], control.limits[0]
    before = state.mode
    if command.presence > state.presence:  # a rise: a second server that repeats another number is no operator
        state.presence, state.presence_ns = command.presence, t_ns
    if command.request_n > state.request_n:
        consider(t_ns, command, control)
    watch_loop(limits, t_ns, state)
    watch_operator(limits, t_ns, state)
    watch_server(limits, silence(state, status.server_ns, t_ns), state)
    watch_pump(limits, silence(state, status.pump_ns, t_ns), state)
    watch_markers(limits, silence(state, state.seen_ns, t_ns), state)
    watch_frozen(limits, u_hat, state)
    watch_error(limits, state)
    watch_oscillation(limits, state)
    watch_residual(limits, state)
    watch_speed(limits, control.v, state)
    watch_flow(measurement, u_hat, control)
    watch_numbers(command, control)
    watch_pressure(limits, measurement, state)
    watch_board(limits, t_ns, measurement, state)
    if state.mode == REST and state.u[0] == 0.0 and state.u[1] == 0.0:
        move(VENTED, state.cause if KEPT_BITS >> state.cause & 1 else RESTED, state)
    state.entered = state.mode != before
    state.begins = is_live(state.mode) and not is_live(before)
    state.last_ns = t_ns


@kernel
def move(mode: int, cause: int, state: Record) -> None:
    """Change the mode and say why. Not in the paper. In place: state.mode, state.cause."""
    state.mode = mode
    state.cause = cause


@kernel
def react(watch: int, state: Record) -> None:
    """Do what the table says when the watchdog `watch` finds its bound passed in this mode.

    Not in the paper. In place: state.mode, state.cause.
    """
    if WATCHED_IN[watch] >> state.mode & 1:
        move(REACTION[watch], CAUSE[watch], state)


@kernel
def is_live(mode: int) -> bool:
    """HOLD, FOLLOW or TRACK: the reference rules u. Not in the paper."""
    return LIVE_BITS >> mode & 1 != 0


@kernel
def is_moving(mode: int) -> bool:
    """FOLLOW or TRACK: the reference itself may move. Not in the paper."""
    return MOVING_BITS >> mode & 1 != 0


@kernel
def silence(state: Record, seen_ns: int, t_ns: int) -> float:
    """Seconds since `seen_ns`, or since the start, without those of the loop's last stall. Not in the paper."""
    since_ns = max(seen_ns, state.start_ns)
    stalled_ns = max(0, state.resume_ns - max(since_ns, state.stall_ns))
    return (t_ns - since_ns - stalled_ns) * 1e-9


@kernel
def present(state: Record, limits: Record, t_ns: int) -> bool:
    """Whether an operator has shown presence within the timeout. Not in the paper."""
    return state.presence_ns > 0 and (t_ns - state.presence_ns) * 1e-9 <= limits.operator_timeout


@kernel
def consider(t_ns: int, command: Record, control: Control) -> None:
    """Accept or refuse the request of `command`, once; after a CLEAR the observer starts again.

    A rig that is stopped already keeps the cause for which it was. Not in the paper. In place: control.state.
    """
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
    elif (request != 0 and state.mode != E_STOP) or request == ASK_CLEAR:
        state.unattended = command.unattended
        move(wanted, OPERATOR, state)
        state.forget = request == ASK_CLEAR
        if state.forget:
            state.forgot_ns = t_ns


@kernel
def watch_loop(limits: Record, t_ns: int, state: Record) -> None:
    """The loop itself stood still: HOLD on resume. Not in the paper. In place: state."""
    if (t_ns - state.last_ns) * 1e-9 > limits.loop_gap:
        state.stall_ns, state.resume_ns = state.last_ns, t_ns
        react(LOOP, state)


@kernel
def watch_operator(limits: Record, t_ns: int, state: Record) -> None:
    """No operator in a moving mode, unless a TRACK run was started as unattended. Not in the paper. In place: state."""
    alone = state.mode == TRACK and state.unattended != 0
    if not alone and not present(state, limits, t_ns):
        react(OPERATOR_SIGN, state)


@kernel
def watch_server(limits: Record, silent: float, state: Record) -> None:
    """Server silent for a while: HOLD, after a longer time ramp to rest. Not in the paper. In place: state."""
    if silent > limits.server_hold:
        react(SERVER_SILENT, state)
    if silent > limits.server_rest:
        react(SERVER_GONE, state)


@kernel
def watch_pump(limits: Record, silent: float, state: Record) -> None:
    """The rig's Python side silent for a while: HOLD, after a longer time ramp to rest.

    Not in the paper. In place: state.
    """
    if silent > limits.pump_hold:
        react(PUMP_SILENT, state)
    if silent > limits.pump_rest:
        react(PUMP_GONE, state)


@kernel
def watch_markers(limits: Record, unseen: float, state: Record) -> None:
    """No usable marker for a while: FAULT. (For less long, `sense` already took the feedback off.)

    Not in the paper. In place: state.
    """
    if unseen > limits.measurement_lost:
        react(MARKERS_JUMPED if state.jumped != 0 else MARKERS_LOST, state)


@kernel
def watch_frozen(limits: Record, u_hat: Array, state: Record) -> None:
    """Samples that come but show no motion at all, not even noise, while the torque changed: FAULT.

    Not in the paper. In place: state.
    """
    change = max(abs(u_hat[0] - state.u_moved[0]), abs(u_hat[1] - state.u_moved[1]))
    still = (state.seen_ns - state.moved_ns) * 1e-9
    if state.used != 0 and still > limits.frozen_time and change > limits.frozen_torque:
        react(MARKERS_FROZEN, state)


@kernel
def watch_error(limits: Record, state: Record) -> None:
    """Tracking error above its limit for its time, in closed loop with the target in reach: FAULT.

    Not in the paper. In place: state.
    """
    if state.off_time > limits.error_time:
        react(ERROR, state)


@kernel
def watch_oscillation(limits: Record, state: Record) -> None:
    """The error swings widely, or fast and by more than the reference's own motion explains: REST.

    HOLD would be no remedy: it keeps on the feedback that makes the arm whip. Chambers that do not follow make it
    swing, too: that is left to their own watchdog. Not in the paper. In place: state.
    """
    if not chambers_follow(state):
        return
    mean_x, mean_y = state.error_mean
    if state.error_square - mean_x * mean_x - mean_y * mean_y > limits.error_rms_max**2 + state.error_first:
        react(ERROR_RMS, state)
    if state.swing_off > limits.swing_time:
        react(OSCILLATION, state)


@kernel
def watch_residual(limits: Record, state: Record) -> None:
    """The observer is off the markers by more than its limit for its time: FAULT. Not in the paper. In place: state."""
    if state.residual_off > limits.residual_time:
        react(RESIDUAL, state)


@kernel
def watch_speed(limits: Record, v: Array, state: Record) -> None:
    """The model moves faster than any actuator: E_STOP, before its numbers are lost.

    Not in the paper. In place: state.
    """
    if speed_of(v) > limits.speed_max:
        react(SPEED, state)


@kernel
def speed_of(v: Array) -> float:
    """Speed of the last rod [m/s], of v (3,N). Not in the paper."""
    last = v.shape[1] - 1
    return math.hypot(v[0, last], v[1, last])


@kernel
def watch_flow(measurement: Record, u_hat: Array, control: Control) -> None:
    """The chambers' pressures are not those that the torques ask for, lag and dead time allowed: E_STOP.

    No command would bring such a chamber to rest: sensor, valve or supply is broken. Not in the paper.
    In place: control.state.
    """
    state = control.state[0]
    note_chambers(measurement, u_hat, DRIVEN_BITS >> state.mode & 1 != 0, control)
    if chambers_broken(state, control.limits[0]):
        react(FLOW, state)


@kernel
def watch_numbers(command: Record, control: Control) -> None:
    """A number in the command or in the estimated state is not finite: E_STOP.

    Not in the paper. In place: control.state.
    """
    state, q, v = control.state[0], control.q, control.v
    total = command_sum(command)
    for row in range(3):
        for i in range(q.shape[1]):
            total += q[row, i] + v[row, i]
    if not state.forget and not math.isfinite(total):
        react(NUMBERS, state)


@kernel
def command_sum(command: Record) -> float:
    """Sum of every real number in the command: not finite if one of them is not. Not in the paper."""
    s = command.settings
    total = s.feedforward_period + s.speed_max + s.acceleration_max
    for j in range(2):
        total += command.target[j] + s.K_P[j] + s.K_I[j] + s.K_FF[j] + s.K_o[j] + s.B_o[j] + s.u_open[j]
    return total


@kernel
def watch_pressure(limits: Record, measurement: Record, state: Record) -> None:
    """A chamber pressure is out of range or not a number: E_STOP. Not in the paper. In place: state."""
    for j in range(measurement.pressures.shape[0]):
        if not limits.pressure_min <= measurement.pressures[j] <= limits.pressure_max:
            react(PRESSURE, state)


@kernel
def watch_board(limits: Record, t_ns: int, measurement: Record, state: Record) -> None:
    """The board of a rig's valves is silent, or drives nothing: E_STOP. Not in the paper. In place: state."""
    if measurement.pressures_ns != 0 and silence(state, measurement.pressures_ns, t_ns) > limits.pressures_lost:
        react(PRESSURES_LOST, state)
