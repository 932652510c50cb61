"""Torques that were planned along the reference, and feedback on what the arm will have done of it.

The plan (`controller/reference/torques.py`) moves the nominal model along the reference, through dead time, lag,
inertia and damping: without any disturbance nothing is left for feedback. What is left is fed back on a prediction: of
the feedback's own torque a part is still on its way, in the lines and in the chambers, and what it will do to the tip
is added to what is measured (Smith, "Closer control of loops with dead time", 1957). So the loop may be as quick as if
nothing were late.
"""

import math

from controller.arrays import Array, Record
from controller.kernels.compiled import kernel
from controller.kernels.control.task_space import attainable, through_sensitivity
from controller.kernels.control.task_space_pi import EXCESS, UNWIND_TIME, forgotten
from controller.kernels.slot import MEMORY
from controller.schema.modes import Law

FF = int(Law.FF)
K_P, K_I, LAG = 0, 1, 2
"""Places in the tuning: its gains, and the time constant with which P follows the error [s]."""
U_INT, ERROR_LOW, STEP, WOUND, ARRIVED, LAST, HEAD, SPARE, RING = 0, 2, 4, 6, 8, 10, 12, 14, 64
"""Places in the memory: the integral's torque [N m], the error that P follows [m], the step of the integral's torque
and the torque that winds it up, of the last tick, what of the feedback has arrived in the chambers, what was fed back
in the last tick [N m], the next place in the ring, room for what `adaptive` remembers, and the ring of what is in the
lines, two numbers a tick."""
ROOM = (MEMORY - RING) // 2


@kernel
def preview(now: Record, reference: Array, tuning: Array, memory: Array, out_wanted: Record) -> None:
    """u = planned + (S^T S + epsilon I)^-1 S^T (K_P e + K_I int e), e = p_ref - tip - S (u_fb - arrived).

    Not in the paper; Eq. UFB is its. In place: memory.
    """
    out_wanted.by_tip = 1
    lead_by_plan(now, out_wanted)
    collect_predicted(now, memory)
    e_1, e_2 = predicted_error(now, memory)
    share = 1.0 if now.switched else now.dt / (tuning[LAG] + now.dt)
    for j in range(2):
        e = e_1 if j == 0 else e_2
        before = memory[ERROR_LOW + j] if share < 1.0 else e
        memory[ERROR_LOW + j] = before + share * (e - before)
    told = now.told
    P_1, P_2 = told * tuning[K_P] * memory[ERROR_LOW], told * tuning[K_P] * memory[ERROR_LOW + 1]
    g_1, g_2 = through_sensitivity(now, now.epsilon, P_1, P_2)
    if not now.live or now.blending or now.law <= FF:
        g_1 = g_2 = memory[U_INT] = memory[U_INT + 1] = 0.0
    elif now.begins and now.closed:
        memory[U_INT], memory[U_INT + 1] = now.u[0] - now.u_ff[0] - g_1, now.u[1] - now.u_ff[1] - g_2
    out_wanted.u_fb[0], out_wanted.u_fb[1] = g_1 + memory[U_INT], g_2 + memory[U_INT + 1]
    if now.begins:
        fill_lines(now, out_wanted, memory)
    note_predicted(now, told * tuning[K_I], (e_1, e_2), memory)
    advance_lines(now, out_wanted, memory)
    show_prediction(now, (e_1, e_2), memory, out_wanted)


@kernel
def lead_by_plan(now: Record, out_wanted: Record) -> None:
    """The feedforward is the plan's, and where there is none the quasi-static one. Not in the paper."""
    there = math.isfinite(now.planned[0] + now.planned[1]) and not now.led
    for j in range(2):
        out_wanted.u_ff[j] = now.planned[j] if there else now.u_ff[j]


@kernel
def predicted_error(now: Record, memory: Array) -> tuple[float, float]:
    """What will be left of the error [m] when all that was fed back has arrived. Not in the paper: Smith (1957)."""
    d_1, d_2 = memory[LAST] - memory[ARRIVED], memory[LAST + 1] - memory[ARRIVED + 1]
    x, y = now.S[0] * d_1 + now.S[1] * d_2, now.S[2] * d_1 + now.S[3] * d_2
    return now.p_ref[0] - now.p_hat[0] - x, now.p_ref[1] - now.p_hat[1] - y


@kernel
def note_predicted(now: Record, gain: float, e: tuple[float, float], memory: Array) -> None:
    """Note what the integral's torque is to collect of this tick. Not in the paper. In place: memory."""
    e_1, e_2 = attainable(now, e[0], e[1])
    s_1, s_2 = through_sensitivity(now, now.epsilon, gain * e_1, gain * e_2)
    for j in range(2):
        memory[WOUND + j] = s_1 if j == 0 else s_2
        memory[STEP + j] = memory[WOUND + j] if now.closed else 0.0


@kernel
def collect_predicted(now: Record, memory: Array) -> None:
    """Let the integral's torque run by the last tick's error, unless that pushes against an edge; unwind what is cut.

    Astrom and Hagglund, "Advanced PID Control". Not in the paper. In place: memory.
    """
    square = now.cut[0] * now.cut[0] + now.cut[1] * now.cut[1]
    pushed = memory[U_INT] * now.cut[0] + memory[U_INT + 1] * now.cut[1]
    share = min(1.0, pushed / square) * now.dt / UNWIND_TIME if square > EXCESS * EXCESS and pushed > 0.0 else 0.0
    held = now.saturated and memory[WOUND] * now.push[0] + memory[WOUND + 1] * now.push[1] > 0.0
    for j in range(2):
        memory[U_INT + j] += (0.0 if held else memory[STEP + j] * now.dt) - share * now.cut[j]
        memory[U_INT + j] -= forgotten(now) * memory[U_INT + j]


@kernel
def fill_lines(now: Record, wanted: Record, memory: Array) -> None:
    """What is fed back as the controller begins has acted for long: it is in chambers and lines already.

    Taken for new, it would be foreseen to move the tip once more. Not in the paper. In place: memory.
    """
    for j in range(2):
        memory[LAST + j] = memory[ARRIVED + j] = wanted.u_fb[j] if now.closed else 0.0
    for i in range(RING, memory.size):
        memory[i] = memory[LAST + (i - RING) % 2]


@kernel
def advance_lines(now: Record, wanted: Record, memory: Array) -> None:
    """Let what is fed back go into the lines, and what comes out of them into the chambers.

    Dead time and lag: paper, "Dynamic observer". In place: memory.
    """
    ticks = min(max(round(now.dead_time / now.dt), 1), ROOM)
    head = int(memory[HEAD]) % ticks
    for j in range(2):
        place = RING + 2 * head + j
        late, memory[place] = memory[place], wanted.u_fb[j] if now.closed else 0.0
        memory[ARRIVED + j] += now.dt / (now.pneumatic_lag + now.dt) * (late - memory[ARRIVED + j])
        memory[LAST + j] = memory[place]
    memory[HEAD] = (head + 1) % ticks


@kernel
def show_prediction(now: Record, e: tuple[float, float], memory: Array, out_wanted: Record) -> None:
    """Signals: the predicted error [m] and the integral's torque [N m]. Not in the paper."""
    for j in range(2):
        out_wanted.signals[j] = e[0] if j == 0 else e[1]
        out_wanted.signals[2 + j] = memory[U_INT + j]
