"""`preview`, with a feedforward that adapts to the arm by what its motion tells.

The plan moves the nominal arm. Of one that is softer, or whose pressures make more torque, a share of the quasi-static
feedforward is too much; one that is later, or less damped, needs another share of its rate. So
    u = planned + sigma_j u_ff,j + tau_j du_ff,j/dt + feedback.
What is missing, w, is the torque that was fed back and has arrived, and what would take the rest of the error away. For
each pair of chambers
    w = (sigma - sigma_j) a + (tau - tau_j) b + mu sign(b) + beta,
a the feedforward as it arrives in the chambers, b its rate, mu friction, beta what stands still: creep, weight, another
rest shape, which are the integral's matter. The four follow by recursive least squares whose covariance P returns to
its prior,
    dP/dt = rate (P_0 - P) - P phi phi^T P / R,    dtheta/dt = P phi (w - phi^T theta) / R,
so nothing is learned of an arm that stands, and P does not grow without a bound. Kulhavy, Zarrop, "On a general concept
of forgetting", Int. J. Control 58 (1993); Ioannou, Sun, "Robust Adaptive Control" (1996), 4.4 (projection).
"""

import math

from controller.arrays import Array, Record
from controller.kernels.compiled import kernel
from controller.kernels.control.preview import ARRIVED, SPARE, preview
from controller.kernels.control.task_space import through_sensitivity
from controller.schema.modes import Law, RowKind

FF, TRAVEL = int(Law.FF), int(RowKind.TRAVEL)
RATE, MOST = 3, 4
"""Places in the tuning: how quickly what was learned makes room [1/s], and the most that sigma may be."""
LEAD_MOST = 0.04
"""The most that tau may be [s]."""
SHORT = 0.01
"""Time constant of the rate of the feedforward that is sent [s]."""
SLOW = 2e-3
"""The tip's speed at which friction has most of its size [m/s]."""
N = 4
PRIOR_SIGMA, PRIOR_TAU, PRIOR_MU, PRIOR_BETA = 0.3, 0.05, 0.01, 0.15
"""Standard deviations before anything is known: sigma, tau [s], and mu and beta [u_max]."""
SPREAD, APART = 0.03, 0.5
"""What w has beyond the four [u_max], and for how long it stays alike [s]: R is the square of the one, times the
other."""
OUTLIER = 2.0
"""So many times SPREAD w is taken for off at most: a jump of the reference tells little of the arm (Huber)."""
QUICK, LINE, CHAMBER, THETA, COVARIANCE = SPARE, SPARE + 2, SPARE + 4, SPARE + 6, SPARE + 6 + 2 * N
"""Places in the memory: the feedforward followed at once, through the line, and through line and chamber, two numbers
each [N m]; theta of each pair, and its P row by row."""


@kernel
def adaptive(now: Record, reference: Array, tuning: Array, memory: Array, out_wanted: Record) -> None:
    """`preview` with a feedforward that adapts to the arm. Not in the paper: see above. In place: memory."""
    preview(now, reference, tuning, memory, out_wanted)
    w_1, w_2 = through_sensitivity(now, now.epsilon, now.p_ref[0] - now.p_hat[0], now.p_ref[1] - now.p_hat[1])
    for j in range(2):
        a, b = arrived_feedforward(now, j, memory)
        theta = memory[THETA + N * j : THETA + N * (j + 1)]
        P = memory[COVARIANCE + N * N * j : COVARIANCE + N * N * (j + 1)]
        w = memory[ARRIVED + j] + (w_1 if j == 0 else w_2)
        if now.begins:
            forget_stiffness(now.u_max, theta, P)
        if now.begins or not adapts(now):
            theta[3] = w  # what is missing where it goes on from is no matter of the motion
        elif tuning[RATE] > 0.0:
            sign = math.tanh(b * math.hypot(now.S[j], now.S[2 + j]) / SLOW)
            learn_stiffness(now, (a, b, sign), w, tuning[RATE], theta, P)
            theta[0] = min(max(theta[0], -tuning[MOST]), tuning[MOST])
            theta[1] = min(max(theta[1], -LEAD_MOST), LEAD_MOST)
        slope = (now.u_ff[j] - memory[QUICK + j]) / SHORT
        out_wanted.u_ff[j] += theta[0] * now.u_ff[j] + theta[1] * slope
        out_wanted.signals[4 + j], out_wanted.signals[6 + j] = theta[0], theta[1]


@kernel
def adapts(now: Record) -> bool:
    """Whether what is missing tells of the arm. Without the tip's own marker it may be the observer's error.

    Not in the paper.
    """
    fed_back = now.live and now.closed and now.law > FF and now.tip_used
    return fed_back and not now.blending and not now.saturated and now.kind != TRAVEL


@kernel
def arrived_feedforward(now: Record, j: int, memory: Array) -> tuple[float, float]:
    """The feedforward of pair j as it arrives [N m], and its rate [N m/s]; the dead time is taken for a lag.

    Dead time and lag: paper, "Dynamic observer". In place: memory.
    """
    dt = now.dt
    for place in range(QUICK + j, THETA, 2):
        if now.begins:
            memory[place] = now.u_ff[j]
    memory[QUICK + j] += dt / (SHORT + dt) * (now.u_ff[j] - memory[QUICK + j])
    memory[LINE + j] += dt / (now.dead_time + dt) * (now.u_ff[j] - memory[LINE + j])
    b = (memory[LINE + j] - memory[CHAMBER + j]) / (now.pneumatic_lag + dt)
    memory[CHAMBER + j] += dt * b
    return memory[CHAMBER + j], b


@kernel
def forget_stiffness(u_max: float, theta: Array, P: Array) -> None:
    """Nothing is known but the prior. Not in the paper. In place: theta, P."""
    for i in range(N):
        theta[i] = 0.0
        for k in range(N):
            P[N * i + k] = prior_variance(i, u_max) if i == k else 0.0


@kernel
def prior_variance(i: int, u_max: float) -> float:
    """Variance of the number i of theta before anything is known. Not in the paper."""
    sd = PRIOR_SIGMA if i == 0 else PRIOR_TAU if i == 1 else u_max * (PRIOR_MU if i == 2 else PRIOR_BETA)
    return sd * sd


@kernel
def learn_stiffness(
    now: Record, felt: tuple[float, float, float], w: float, rate: float, theta: Array, P: Array
) -> None:
    """One tick of the least squares, of a, b and the sign of b. Not in the paper: see above. In place: theta, P."""
    a, b, sign = felt
    R = (SPREAD * now.u_max) ** 2 * APART / now.dt
    k_0 = P[0] * a + P[1] * b + P[2] * sign + P[3]
    k_1 = P[4] * a + P[5] * b + P[6] * sign + P[7]
    k_2 = P[8] * a + P[9] * b + P[10] * sign + P[11]
    k_3 = P[12] * a + P[13] * b + P[14] * sign + P[15]
    whole = R + a * k_0 + b * k_1 + sign * k_2 + k_3
    missing, most = w - theta[2] * sign - theta[3], OUTLIER * SPREAD * now.u_max
    missing = min(max(missing, -most), most) / whole
    back = rate * now.dt
    for i in range(N):
        k_i = k_0 if i == 0 else k_1 if i == 1 else k_2 if i == 2 else k_3
        theta[i] += k_i * missing
        for k in range(i + 1):
            k_k = k_0 if k == 0 else k_1 if k == 1 else k_2 if k == 2 else k_3
            kept = (1.0 - back) * (P[N * i + k] - k_i * k_k / whole)
            P[N * i + k] = P[N * k + i] = kept + (back * prior_variance(i, now.u_max) if i == k else 0.0)
