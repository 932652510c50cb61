"""The paper's task-space PI (paper, "Task-space PI control"), as a controller: with the integral kept as a torque, or
to the paper's letter.
"""

import math

from controller.arrays import Array, Pair, Record
from controller.kernels.compiled import kernel
from controller.kernels.control.task_space import attainable, through_sensitivity
from controller.schema.modes import Law, RowKind

FF_P, FF_I, FF_PI = int(Law.FF_P), int(Law.FF_I), int(Law.FF_PI)
TRAVEL = int(RowKind.TRAVEL)
FORGET_WAY = 0.4
"""On the way to another pose the integral, which fits the one that is left, is forgotten over this way (ours) [m]."""
UNWIND_TIME = 0.2
"""In which the integral's torque loses what is cut away of it (ours) [s]."""
EXCESS = 1e-9
"""A torque further outside the admissible ones than this is cut [N m]."""
INTEGRAL, U_INT, ERROR_LOW, COLLECTED, WOUND, STEP, FORGOTTEN = 0, 2, 4, 6, 8, 10, 12
"""Places in the memory, two numbers each but the last: the integral [m s], its torque [N m], the error that P follows
[m]; of the last tick the error to be collected [m], the torque that winds the integral up, the step of its torque, and
by how much the integral is forgotten."""


@kernel
def paper(now: Record, reference: Array, tuning: Array, memory: Array, out_wanted: Record) -> None:
    """Eq. FDES and Eq. UFB (paper, "Task-space PI control"), but the integral is collected and kept as a torque.

    The S of the pose at hand turns the paper's integral into torque. Of an arm that is softer than its model the
    integral is large, and S follows the arm that swings: a constant integral then makes a torque that swings, and the
    swing grows. Kept as a torque it stays constant. In place: memory.
    """
    task_space_pi(now, True, memory, out_wanted)


@kernel
def letter(now: Record, reference: Array, tuning: Array, memory: Array, out_wanted: Record) -> None:
    """Eq. FDES and Eq. UFB to the letter in TRACK (paper, "Task-space PI control"): S turns the integral into torque.

    Where the tip is led by hand, of which the paper's own law has no limits, it is `paper`. In place: memory.
    """
    task_space_pi(now, now.led, memory, out_wanted)


@kernel
def task_space_pi(now: Record, kept: bool, memory: Array, out_wanted: Record) -> None:
    """u_fb by P and I, with the integral `kept` as a torque or turned into one by S. Eq. FDES, Eq. UFB: paper.

    In place: memory.
    """
    out_wanted.by_tip = kept
    integrates = now.law == FF_I or now.law == FF_PI
    collect(now, kept, memory)
    follow_error(now, now.feedback_lag if now.led and not now.switched else 0.0, memory)
    if not now.live or not integrates or now.blending:
        for j in range(2):
            memory[INTEGRAL + j] = memory[U_INT + j] = 0.0
    keep(now, kept, memory)
    f_1, f_2 = effort(now, kept, memory)
    g_1, g_2 = through_sensitivity(now, now.epsilon, f_1, f_2)
    if now.begins and now.closed and integrates:
        memory[U_INT], memory[U_INT + 1] = now.u[0] - now.u_ff[0] - g_1, now.u[1] - now.u_ff[1] - g_2
    out_wanted.u_fb[0], out_wanted.u_fb[1] = g_1 + memory[U_INT], g_2 + memory[U_INT + 1]
    note(now, integrates, memory)
    for j in range(2):
        out_wanted.integral[j] = memory[INTEGRAL + j]


@kernel
def effort(now: Record, kept: bool, memory: Array) -> Pair:
    """Desired task-space effort f_des [m], but for that of the integral. Eq. FDES: paper, "Task-space PI control"."""
    P, told = now.law == FF_P or now.law == FF_PI, now.told if kept else 1.0
    f_1, f_2 = P * now.K_P[0] * memory[ERROR_LOW], P * now.K_P[1] * memory[ERROR_LOW + 1]
    return told * f_1 + now.K_FF[0] * now.p_ref_dot[0], told * f_2 + now.K_FF[1] * now.p_ref_dot[1]  # Eq. FDES


@kernel
def follow_error(now: Record, lag: float, memory: Array) -> None:
    """Let the error that P feeds back follow the error with time constant `lag` [s]. Not in the paper.

    In place: memory.
    """
    share = now.dt / (lag + now.dt)
    for j in range(2):
        before = memory[ERROR_LOW + j] if share < 1.0 else now.error[j]  # then what was before counts no more
        memory[ERROR_LOW + j] = before + share * (now.error[j] - before)


@kernel
def keep(now: Record, kept: bool, memory: Array) -> None:
    """Make the integral and its torque agree: where the torque is kept, the integral is what the paper's law needs.

    Eq. UFB: paper, "Task-space PI control". In place: memory.
    """
    if not kept:
        f_1, f_2 = now.K_I[0] * memory[INTEGRAL], now.K_I[1] * memory[INTEGRAL + 1]
        memory[U_INT], memory[U_INT + 1] = through_sensitivity(now, now.epsilon, f_1, f_2)
        return
    for j in range(2):
        f = now.S[2 * j] * memory[U_INT] + now.S[2 * j + 1] * memory[U_INT + 1]
        if now.K_I[j] > 0.0:
            memory[INTEGRAL + j] = f / now.K_I[j]


@kernel
def note(now: Record, integrates: bool, memory: Array) -> None:
    """Note what the integral is to collect of this tick, once it is known how much of the torque was sent.

    An error that no torque can change, as along the straight backbone, is not collected. The integral: paper,
    "Task-space PI control". In place: memory.
    """
    collects = now.closed and integrates
    e_1, e_2 = attainable(now, now.error[0], now.error[1])
    w_1, w_2 = through_sensitivity(now, now.epsilon, now.K_I[0] * now.error[0], now.K_I[1] * now.error[1])
    K_1, K_2 = now.told * now.K_I[0], now.told * now.K_I[1]
    s_1, s_2 = through_sensitivity(now, now.epsilon, K_1 * e_1, K_2 * e_2)
    memory[COLLECTED], memory[COLLECTED + 1] = (e_1, e_2) if collects else (0.0, 0.0)
    memory[WOUND], memory[WOUND + 1] = w_1, w_2
    memory[STEP], memory[STEP + 1] = (s_1, s_2) if collects else (0.0, 0.0)
    memory[FORGOTTEN] = forgotten(now) if collects else 0.0


@kernel
def forgotten(now: Record) -> float:
    """Share of the integral that is forgotten in this tick: it fits the pose that is left. Not in the paper."""
    return -math.expm1(-now.way / FORGET_WAY) if now.kind == TRAVEL else 0.0


@kernel
def collect(now: Record, kept: bool, memory: Array) -> None:
    """Let the integral run by the last tick's error; held while saturated, but for steps that lead back.

    The integral: paper, "Task-space PI control". Conditional anti-windup is not in the paper. In place: memory.
    """
    if kept:
        unwind(now, memory)
    if now.saturated and memory[WOUND] * now.push[0] + memory[WOUND + 1] * now.push[1] > 0.0:
        return
    for j in range(2):
        if kept:
            memory[U_INT + j] -= memory[FORGOTTEN] * memory[U_INT + j] - memory[STEP + j] * now.dt
        else:
            memory[INTEGRAL + j] -= memory[FORGOTTEN] * memory[INTEGRAL + j] - memory[COLLECTED + j] * now.dt


@kernel
def unwind(now: Record, memory: Array) -> None:
    """Let the integral's torque lose what of it is cut away anyway, where it is kept.

    What is left of a torque far beyond an edge depends on S, and S on the pose: an arm that stood still was driven by
    its own estimate's swings. No more than what the integral itself pushes that way is taken from it (ours).
    Back-calculation: Astrom and Hagglund, "Advanced PID Control". Not in the paper. In place: memory.
    """
    cut_1, cut_2 = now.cut[0], now.cut[1]
    square = cut_1 * cut_1 + cut_2 * cut_2
    pushed = memory[U_INT] * cut_1 + memory[U_INT + 1] * cut_2
    if square > EXCESS * EXCESS and pushed > 0.0:
        share = min(1.0, pushed / square) * now.dt / UNWIND_TIME
        memory[U_INT], memory[U_INT + 1] = memory[U_INT] - share * cut_1, memory[U_INT + 1] - share * cut_2
