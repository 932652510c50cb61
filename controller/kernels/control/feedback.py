"""The controller in the slot is asked; what it says is made continuous at a switch, and admissible."""

import math

from controller.arrays import Record
from controller.kernels.compiled import kernel
from controller.kernels.control.begin import feeds_back, tip_fed_back
from controller.kernels.control.feedforward import OPEN_LOOP, towards
from controller.kernels.control.task_space import squared, update_sensitivity
from controller.kernels.function_pointer import call_at
from controller.kernels.memory import Control
from controller.kernels.model.polygon import nearest_by
from controller.kernels.observer.observer import TIP
from controller.kernels.safety.oscillation import forget_tracking, note_tracking
from controller.kernels.safety.safety import E_STOP, FOLLOW, HOLD, NUMBERS, TRACK, is_live, react
from controller.schema.modes import Law, RowKind

SENSORS = TIP.bit_length()
"""The tip's is the last."""
FF_P = int(Law.FF_P)
KNOWN, FED = int(RowKind.KNOWN), int(RowKind.FED)
BUMP_TIME = 0.2
"""Time constant with which the jump of u at a switch fades (ours) [s]."""
BLUNT = 0.1
"""Share of S^T S + BLUNT tr(S^T S) I by which torques are near to one another where they are cut by the tip (ours)."""
EXCESS = 1e-9
"""A sum further outside the admissible torques than this counts as saturated [N m]."""


@kernel
def feed_back(settings: Record, control: Control, telemetry: Record) -> None:
    """Set the error and u_fb: what the controller adds to u_ff, and what keeps u continuous where it was switched.

    On the way to another branch nothing is fed back: the way leads through a fold, where S tells nothing.
    Paper, "Task-space PI control": e = p_ref - p_data; the slot is not in it. In place: control.state, telemetry.error.
    """
    state, wanted = control.state[0], control.slot.wanted[0]
    live = is_live(state.mode) and settings.law != OPEN_LOOP
    feeds = live and feeds_back(settings) and not state.blending
    closed = feeds and state.used != 0
    tip_x, tip_y = tip_fed_back(state.used, telemetry)
    telemetry.error[0], telemetry.error[1] = state.p_ref[0] - tip_x, state.p_ref[1] - tip_y
    led = state.mode != TRACK
    how = live + 2 * closed + 4 * (state.used & TIP != 0) + 8 * (state.kind >= KNOWN) + 16 * led
    told = told_of_tip(state.used, control.controller[0])
    choose_velocity_gain(settings, control.controller[0], state)
    chosen = choose_controller(settings, control)
    switched = scheme_changed(settings, how, told, state) or chosen
    update_sensitivity(control)
    show(settings, live, closed, switched, chosen, telemetry, control)
    ask(settings, control)
    g_1, g_2 = wanted.u_ff[0] - state.u_ff[0], wanted.u_ff[1] - state.u_ff[1]
    if closed:
        g_1, g_2 = g_1 + wanted.u_fb[0], g_2 + wanted.u_fb[1]
    stays = state.mode == HOLD and settings.law == FF_P  # nothing else would hold the arm where it is
    fade_bump(g_1, g_2, live, switched, 1.0 if stays else math.exp(-control.dt / BUMP_TIME), state)
    if state.moved_over:  # it is the model that moves, not the arm: the tip that was estimated before is wrong
        forget_tracking(telemetry.error, state)
    elif closed == feeds:  # else no marker is in sight for a moment: nothing is known of the error, nothing forgotten
        note_tracking(telemetry.error, closed, control)


@kernel
def choose_controller(settings: Record, control: Control) -> bool:
    """Take the controller of the settings, but while the tip is on its way: whether it is another one than before.

    It remembers nothing where it is another one, or where the arm is armed. Not in the paper.
    In place: control.state.controller, control.slot.memory.
    """
    state, slot, wanted = control.state[0], control.slot, settings.controller
    moving = state.mode == TRACK or state.mode == FOLLOW
    chosen = not moving and wanted != state.controller and 0 <= wanted < slot.laws.size
    if chosen:
        state.controller = wanted
    if chosen or state.begins:
        for i in range(slot.memory.size):
            slot.memory[i] = 0.0
    return chosen


@kernel
def show(
    settings: Record, live: bool, closed: bool, switched: bool, chosen: bool, telemetry: Record, control: Control
) -> None:
    """Fill in what the controller is shown of this tick. Not in the paper. In place: control.slot.now."""
    state, now, plan, bounds = control.state[0], control.slot.now[0], control.plan[0], control.controller[0]
    tracks = state.mode == TRACK
    now.dt, now.law, now.live, now.led, now.closed = control.dt, settings.law, live, not tracks, closed
    now.blending, now.switched, now.kind = state.blending, switched, state.kind
    now.begins = state.begins or chosen
    now.row = state.row if tracks else -1
    now.rows, now.again, now.left = plan.rows, plan.again, plan.ticks - state.followed
    now.way = math.hypot(state.wish_dot[0], state.wish_dot[1]) * control.dt
    now.tip[0], now.tip[1] = tip_fed_back(state.used, telemetry)
    now.tip_age, now.told = telemetry.measurement_age, state.told
    now.saturated, now.stands, now.share = state.saturated, state.stands, state.share
    now.epsilon, now.feedback_lag = bounds.epsilon, bounds.feedback_lag
    now.dead_time, now.pneumatic_lag = bounds.dead_time, bounds.pneumatic_lag
    now.u_max, now.tip_used = control.smap.polygon.bounds[0], state.used & TIP != 0
    for j in range(4):
        now.S[j] = state.S[j]
    for j in range(2):
        now.p_ref[j], now.p_ref_dot[j], now.p_hat[j] = state.p_ref[j], state.p_ref_dot[j], telemetry.p_hat[j]
        now.error[j], now.weak[j] = telemetry.error[j], state.weak[j]
        now.u_ff[j], now.u[j], now.cut[j], now.push[j] = state.u_ff[j], state.u[j], state.cut[j], state.push[j]
        now.planned[j] = control.slot.planned[state.planned_row, j] if tracks else math.nan
        now.K_P[j], now.K_I[j], now.K_FF[j] = settings.K_P[j], settings.K_I[j], state.K_FF[j]


@kernel
def ask(settings: Record, control: Control) -> None:
    """Let the controller in force say what it wants. Not in the paper. In place: control.slot."""
    slot = control.slot
    now, wanted = slot.now[0], slot.wanted[0]
    for j in range(2):
        wanted.u_ff[j], wanted.u_fb[j] = now.u_ff[j], 0.0
    call_at(slot.laws[control.state[0].controller], (now, control.reference, settings.tuning, slot.memory, wanted))


@kernel
def told_of_tip(used: int, bounds: Record) -> float:
    """Share of P and I that the markers in use, as bits of `used`, are worth where the tip is led by hand.

    In a body that bends evenly a point at s moves as s^2: what the outermost marker at s tells of the tip is (s/L)^2,
    and `full_gains_from`^2 of it is enough. The rest of the estimate is the model's own, and swings where it is fed
    back in full. Any marker is worth `least_gains`. `bounds` is a record of ControllerParameters. Not in the paper.
    """
    outermost = 0
    for i in range(SENSORS):
        if used >> i & 1:
            outermost = i + 1
    share, full = outermost / SENSORS, bounds.full_gains_from
    return 1.0 if share >= full else max(bounds.least_gains, (share / full) ** 2)


@kernel
def fade_bump(g_1: float, g_2: float, live: bool, switched: bool, fade: float, state: Record) -> None:
    """u_fb = feedback g + bump [N m]: at a switch the bump takes up the jump of u, then it fades.

    Not in the paper, which does not switch. In place: state.bump, state.u_fb.
    """
    for j in range(2):
        raw = g_1 if j == 0 else g_2
        if not live:
            state.bump[j] = 0.0
        elif switched:
            state.bump[j] = state.u[j] - state.u_ff[j] - raw
        else:
            state.bump[j] *= fade
        state.u_fb[j] = raw + state.bump[j]


@kernel
def choose_velocity_gain(settings: Record, bounds: Record, state: Record) -> None:
    """K_FF is the operator's; where that is 0 a reference whose figures were published with another one has that.

    Eq. FDES: paper, on in Task 2 and for the circles of Task 3, off in Task 5. In place: state.K_FF.
    """
    own = state.kind == FED and settings.K_FF[0] == 0.0 and settings.K_FF[1] == 0.0
    for j in range(2):
        state.K_FF[j] = bounds.reference_K_FF if own else settings.K_FF[j]


@kernel
def scheme_changed(settings: Record, how: int, told: float, state: Record) -> bool:
    """Whether law, gains, source of the error, fading (`how`) or share (`told`) differ from the last tick's.

    Not in the paper, which does not switch. In place: state.scheme, state.told, state.gains.
    """
    scheme = 32 * settings.law + how
    changed = scheme != state.scheme or told != state.told
    state.scheme, state.told = scheme, told
    for j in range(2):
        changed |= settings.K_P[j] != state.gains[j]
        changed |= settings.K_I[j] != state.gains[2 + j]
        changed |= state.K_FF[j] != state.gains[4 + j]
        state.gains[j], state.gains[2 + j], state.gains[4 + j] = settings.K_P[j], settings.K_I[j], state.K_FF[j]
    return changed


@kernel
def saturate(control: Control, telemetry: Record) -> None:
    """u = u_ff + u_fb, brought to the nearest admissible torque; what is cut away the controller sees in the next tick.

    Its rate is bounded but where a plan may step. Not a number ends here: E_STOP with u = 0. Eq. SAT: paper,
    "Task-space PI control" and "Hardware setup"; what is nearest is ours. In place: control.state, telemetry.saturated.
    """
    state = control.state[0]
    sum_1, sum_2 = state.u_ff[0] + state.u_fb[0], state.u_ff[1] + state.u_fb[1]
    H11, H12, H22 = nearness(control.slot.wanted[0].by_tip, state)
    u1, u2 = nearest_by(control.smap.polygon, (sum_1, sum_2), (H11, H12, H22))  # Eq. SAT
    if not math.isfinite(u1 + u2):
        react(NUMBERS, state)
    if state.mode == HOLD or state.mode == FOLLOW:
        u1, u2 = towards(state.u, u1, u2, control.controller[0].torque_slew_max * control.dt)
    if state.mode == E_STOP:
        u1 = u2 = 0.0
    state.u[0], state.u[1] = u1, u2
    cut_1, cut_2 = sum_1 - u1, sum_2 - u2
    state.saturated = max(abs(cut_1), abs(cut_2)) > EXCESS
    state.cut[0], state.cut[1] = cut_1, cut_2
    state.push[0], state.push[1] = H11 * cut_1 + H12 * cut_2, H12 * cut_1 + H22 * cut_2
    telemetry.saturated = state.saturated


@kernel
def nearness(by_tip: bool, state: Record) -> tuple[float, float, float]:
    """H11, H12, H22 by which torques are near to one another where they are cut: as they are, or `by_tip`.

    By the tip near is what moves it by little, S^T S and some of its trace. At an edge only one way is left to the
    feedback: torques that are nearest as such may move the tip far more than was asked for, and an arm whose tip is
    only estimated swung up there. Not in the paper, which does not say how it saturates.
    """
    H11, H12, H22 = squared(state)
    if not by_tip or not 0.0 < H11 + H22 < math.inf:  # nor is it with an S that is no number
        return 1.0, 0.0, 1.0
    least = BLUNT * (H11 + H22)
    return H11 + least, H12, H22 + least
