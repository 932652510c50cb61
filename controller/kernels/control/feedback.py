"""Task-space PI feedback through the sensitivity at the observer's pose, saturation and anti-windup."""

import math

from controller.arrays import Array, Pair, Record
from controller.kernels.compiled import kernel
from controller.kernels.control.begin import feeds_back, tip_fed_back
from controller.kernels.control.feedforward import OPEN_LOOP, towards
from controller.kernels.control.task_space import attainable, squared, through_sensitivity, update_sensitivity
from controller.kernels.memory import Control
from controller.kernels.model.polygon import nearest_by
from controller.kernels.observer.observer import TIP
from controller.kernels.safety.oscillation import forget_tracking, note_tracking
from controller.kernels.safety.safety import E_STOP, FOLLOW, HOLD, NUMBERS, TRACK, is_live, react
from controller.schema.modes import Law, RowKind

SENSORS = TIP.bit_length()
"""The tip's is the last."""
FF_P, FF_I, FF_PI = int(Law.FF_P), int(Law.FF_I), int(Law.FF_PI)
KNOWN, TRAVEL, FED = int(RowKind.KNOWN), int(RowKind.TRAVEL), int(RowKind.FED)
BUMP_TIME = 0.2
"""Time constant with which the jump of u at a switch fades (ours) [s]."""
FORGET_WAY = 0.4
"""On the way to another pose the integral, which fits the one that is left, is forgotten over this way (ours) [m]."""
BLUNT = 0.1
"""Share of S^T S that all torques are taken to move the tip by at least, where they are cut (ours)."""
UNWIND_TIME = 0.2
"""In which the integral's torque loses what is cut away of it (ours) [s]."""
EXCESS = 1e-9
"""A sum further outside the admissible torques than this counts as saturated [N m]."""


@kernel
def feed_back(settings: Record, control: Control, telemetry: Record) -> None:
    """Set the error and u_fb: the law's feedback, plus what keeps u continuous where the law has just been switched.

    On the way to another branch nothing is fed back: the way leads through a fold, where S tells nothing. Where the tip
    is led by hand, P acts on what is slower than the first mode, whose damping was not measured: it drives a swing that
    is damped by less than a fifth. P and I then have the share that the markers tell of the tip (`told_of_tip`).
    Paper, "Task-space PI control": e = p_ref - p_data; the rest is not in it. In place: control.state, telemetry.error.
    """
    state = control.state[0]
    live = is_live(state.mode) and settings.law != OPEN_LOOP
    wanted = live and feeds_back(settings) and not state.blending
    closed = wanted and state.used != 0
    measured = state.used & TIP
    tip_x, tip_y = tip_fed_back(state.used, telemetry)
    telemetry.error[0], telemetry.error[1] = state.p_ref[0] - tip_x, state.p_ref[1] - tip_y
    led = state.mode != TRACK
    how = live + 2 * closed + 4 * (measured != 0) + 8 * (state.kind >= KNOWN) + 16 * led
    told = told_of_tip(state.used, control.controller[0]) if led else 1.0
    choose_velocity_gain(settings, control.controller[0], state)
    switched = scheme_changed(settings, how, told, state)
    lag = control.controller[0].feedback_lag if led and not switched else 0.0
    update_sensitivity(control)
    smooth(telemetry.error, control.dt / (lag + control.dt), state)
    if not live or not integrates(settings) or state.blending:
        state.integral[0] = state.integral[1] = state.u_int[0] = state.u_int[1] = 0.0
    keep_integral(settings, led, control)
    f_1, f_2 = effort(state, settings)
    g_1, g_2 = through_sensitivity(control, f_1, f_2)
    if closed:
        g_1, g_2 = g_1 + state.u_int[0], g_2 + state.u_int[1]
    else:
        g_1 = g_2 = 0.0
    stays = state.mode == HOLD and settings.law == FF_P  # nothing else would hold the arm where it is
    fade_bump(g_1, g_2, live, switched, 1.0 if stays else math.exp(-control.dt / BUMP_TIME), state)
    if state.begins and closed and integrates(settings):
        take_over(state)
    if state.moved_over:  # it is the model that moves, not the arm: the tip that was estimated before is wrong
        forget_tracking(telemetry.error, state)
    elif closed == wanted:  # else no marker is in sight for a moment: nothing is known of the error, nothing forgotten
        note_tracking(telemetry.error, closed, control)


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
def integrates(settings: Record) -> bool:
    """Whether the law has an integral: paper, "Task-space PI control"."""
    return settings.law == FF_I or settings.law == FF_PI


@kernel
def take_over(state: Record) -> None:
    """Where a live mode begins what the torques in force have over the model's is the integral's.

    So the arm stays where it is, and the model's error there is known from the start. Not in the paper, see `begin`.
    In place: state.u_int, state.bump.
    """
    for j in range(2):
        state.u_int[j] += state.bump[j]
        state.bump[j] = 0.0


@kernel
def effort(state: Record, settings: Record) -> Pair:
    """Desired task-space effort f_des [m] of the law in force, but for that of the integral: see `keep_integral`.

    Eq. FDES: paper, "Task-space PI control".
    """
    P = settings.law == FF_P or settings.law == FF_PI
    f_1, f_2 = P * settings.K_P[0] * state.error_low[0], P * settings.K_P[1] * state.error_low[1]
    f_1, f_2 = state.told * f_1, state.told * f_2
    return f_1 + state.K_FF[0] * state.p_ref_dot[0], f_2 + state.K_FF[1] * state.p_ref_dot[1]  # Eq. FDES


@kernel
def choose_velocity_gain(settings: Record, bounds: Record, state: Record) -> None:
    """K_FF is the operator's; where that is 0 a reference whose figures were published with another one has that.

    Eq. FDES: paper, on in Task 2 and for the circles of Task 3, off in Task 5. In place: state.K_FF.
    """
    own = state.kind == FED and settings.K_FF[0] == 0.0 and settings.K_FF[1] == 0.0
    for j in range(2):
        state.K_FF[j] = bounds.reference_K_FF if own else settings.K_FF[j]


@kernel
def keep_integral(settings: Record, led: bool, control: Control) -> None:
    """Make the torque of the integral and the integral agree; where the tip is led by hand it is the torque that stays.

    In TRACK the S of the pose at hand turns the integral into torque (Eq. FDES, Eq. UFB: paper, "Task-space PI
    control"). An arm that is led fast passes poses of very different S, and swings about them: there that would turn a
    constant integral into a torque that swings. So the torque stays as it was collected, and the integral is the one
    that the paper's law would need for it (ours). In place: control.state.
    """
    state, K_I = control.state[0], settings.K_I
    if not led:
        u_1, u_2 = through_sensitivity(control, K_I[0] * state.integral[0], K_I[1] * state.integral[1])
        state.u_int[0], state.u_int[1] = u_1, u_2
        return
    for j in range(2):
        f = state.S[2 * j] * state.u_int[0] + state.S[2 * j + 1] * state.u_int[1]
        if K_I[j] > 0.0:
            state.integral[j] = f / K_I[j]


@kernel
def smooth(error: Array, share: float, state: Record) -> None:
    """Let the error that the P part feeds back follow `error` (2,) [m]: by `share` of what is between them.

    Not in the paper: see `feed_back`. In place: state.error_low.
    """
    for j in range(2):
        before = state.error_low[j] if share < 1.0 else error[j]  # of 1, what was before counts no more, number or not
        state.error_low[j] = before + share * (error[j] - before)


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
def saturate(settings: Record, control: Control, telemetry: Record) -> None:
    """u = u_ff + u_fb, brought to the nearest admissible torque; the integral runs on, unless that would wind it up.

    Its rate is bounded but where a plan may step. Not a number ends here: E_STOP with u = 0. Eq. SAT: paper,
    "Task-space PI control" and "Hardware setup"; what is nearest is ours. In place: control.state, telemetry.saturated.
    """
    state = control.state[0]
    sum_1, sum_2 = state.u_ff[0] + state.u_fb[0], state.u_ff[1] + state.u_fb[1]
    H11, H12, H22 = nearness(state)
    u1, u2 = nearest_by(control.smap.polygon, (sum_1, sum_2), (H11, H12, H22))  # Eq. SAT
    if not math.isfinite(u1 + u2):
        react(NUMBERS, state)
    if state.mode != TRACK:
        unwind(sum_1 - u1, sum_2 - u2, control.dt, state)
    if state.mode == HOLD or state.mode == FOLLOW:
        u1, u2 = towards(state.u, u1, u2, control.controller[0].torque_slew_max * control.dt)
    if state.mode == E_STOP:
        u1 = u2 = 0.0
    state.u[0], state.u[1] = u1, u2
    telemetry.saturated = max(abs(sum_1 - u1), abs(sum_2 - u2)) > EXCESS
    cut_1, cut_2 = sum_1 - u1, sum_2 - u2
    integrate(settings, telemetry, H11 * cut_1 + H12 * cut_2, H12 * cut_1 + H22 * cut_2, control)


@kernel
def unwind(cut_1: float, cut_2: float, dt: float, state: Record) -> None:
    """Let the integral's torque lose what of it is cut away [N m] anyway, where the tip is led by hand.

    What is left of a torque far beyond an edge depends on S, and S on the pose: an arm that stood still was driven by
    its own estimate's swings. No more than what the integral itself pushes that way is taken from it (ours).
    Back-calculation: Astrom and Hagglund, "Advanced PID Control". Not in the paper. In place: state.u_int.
    """
    square = cut_1 * cut_1 + cut_2 * cut_2
    pushed = state.u_int[0] * cut_1 + state.u_int[1] * cut_2
    if square > EXCESS * EXCESS and pushed > 0.0:
        share = min(1.0, pushed / square) * dt / UNWIND_TIME
        state.u_int[0], state.u_int[1] = state.u_int[0] - share * cut_1, state.u_int[1] - share * cut_2


@kernel
def nearness(state: Record) -> tuple[float, float, float]:
    """H11, H12, H22 by which torques are near to one another where they are cut: in TRACK as they are.

    Where the tip is led by hand near is what moves the tip by little, S^T S and some of its trace. At an edge only one
    way is left to the feedback: torques that are nearest as such may move the tip far more than was asked for, and an
    arm whose tip is only estimated swung up there. Not in the paper, which does not say how it saturates.
    """
    H11, H12, H22 = squared(state)
    if state.mode == TRACK or not 0.0 < H11 + H22 < math.inf:  # nor is it with an S that is no number
        return 1.0, 0.0, 1.0
    least = BLUNT * (H11 + H22)
    return H11 + least, H12, H22 + least


@kernel
def integrate(settings: Record, telemetry: Record, push_1: float, push_2: float, control: Control) -> None:
    """Let the integral run; held while saturated, but for steps that lead back (conditional anti-windup).

    `push` is against the edge of the admissible torques, at a right angle to it. An error that no torque can change, as
    along the straight backbone, is not collected. The integral: paper, "Task-space PI control". Anti-windup is not in
    the paper. In place: control.state.integral; where the tip is led by hand control.state.u_int, `keep_integral`.
    """
    state, e = control.state[0], telemetry.error
    closed = state.scheme & 2
    if not closed or not integrates(settings):
        return
    if telemetry.saturated:
        w_1, w_2 = through_sensitivity(control, settings.K_I[0] * e[0], settings.K_I[1] * e[1])
        if w_1 * push_1 + w_2 * push_2 > 0.0:
            return
    e_1, e_2 = attainable(state, e[0], e[1])
    if state.mode != TRACK:
        K_1, K_2 = state.told * settings.K_I[0], state.told * settings.K_I[1]
        u_1, u_2 = through_sensitivity(control, K_1 * e_1, K_2 * e_2)
        state.u_int[0], state.u_int[1] = state.u_int[0] + u_1 * control.dt, state.u_int[1] + u_2 * control.dt
        return
    way = math.hypot(state.wish_dot[0], state.wish_dot[1]) * control.dt
    kept = math.exp(-way / FORGET_WAY) if state.kind == TRAVEL else 1.0
    state.integral[0] = kept * state.integral[0] + e_1 * control.dt
    state.integral[1] = kept * state.integral[1] + e_2 * control.dt
