"""Task-space effort to torques, through S at the observer's pose (paper, "Task-space PI control")."""

import math

from controller.arrays import Pair, Record
from controller.kernels.compiled import kernel
from controller.kernels.control.inverse import way_down
from controller.kernels.memory import Control
from controller.kernels.model.equilibrium import factor, under_pressure
from controller.kernels.model.sensitivity import sensitivity, side_of
from controller.kernels.model.statics import is_linear
from controller.kernels.safety.safety import is_live
from controller.schema.modes import RowKind

KNOWN = int(RowKind.KNOWN)


@kernel
def update_sensitivity(control: Control) -> None:
    """S at the observer's pose, its weakest direction in the task space, and how much feedback is let through along it.

    The share is (sigma_2 / (weak_ratio sigma_1))^2, at most 1: the torque per error then goes to zero with sigma_2,
    where the paper's law alone would ask for 1 / sigma_2. But for the library's shapes it is 0 where the arm is on the
    other side of a fold than its feedforward: there S leads on into the other pose, and away from the reference. A pose
    that gravity would topple has no S at all.
    S online: paper, "Task-space PI control". The rest is not in the paper. In place: control.
    """
    state, bounds = control.state[0], control.controller[0]
    ratio = bounds.weak_ratio if state.kind >= KNOWN else bounds.weak_ratio_live
    statics = control.smap.statics
    u1, u2 = state.u[0], state.u[1]
    body = under_pressure(statics.body, u1, u2, control.scratch)
    state.stands = is_linear(statics) or factor(body, control.q[2], control.scratch.pivot)
    S11, S12, S21, S22 = sensitivity(statics, control.q[2], u1, u2, control.scratch)
    state.S[0], state.S[1], state.S[2], state.S[3] = S11, S12, S21, S22
    A11, A12, A22 = S11 * S11 + S12 * S12, S11 * S21 + S12 * S22, S21 * S21 + S22 * S22
    det = S11 * S22 - S12 * S21
    strong = 0.5 * (A11 + A22) + math.hypot(0.5 * (A11 - A22), A12)
    state.weak[0], state.weak[1] = way_down(A11, A12, A22, det * det / strong, 0.0, 0.0)
    square = det * det
    if is_live(state.mode) and state.kind < KNOWN:
        side = side_of(control.smap.statics, state.u_ff[0], state.u_ff[1], control.scratch)
        square = max(0.0, min(square, det * side))
    state.share = min(1.0, square / (ratio * strong) ** 2) if ratio > 0.0 else 1.0


@kernel
def attainable(at: Record, f_1: float, f_2: float) -> Pair:
    """Task-space vector f with its part along the weakest direction faded; `at` holds stands, weak and share.

    Not in the paper: see `update_sensitivity`.
    """
    if not at.stands:
        return 0.0, 0.0
    cut = (1.0 - at.share) * (at.weak[0] * f_1 + at.weak[1] * f_2)
    return f_1 - cut * at.weak[0], f_2 - cut * at.weak[1]


@kernel
def squared(at: Record) -> tuple[float, float, float]:
    """Entries 11, 12, 22 of S^T S [m^2/(N m)^2]: by how much torques move the tip. Eq. UFB: paper."""
    S11, S12, S21, S22 = at.S
    return S11 * S11 + S21 * S21, S11 * S12 + S21 * S22, S12 * S12 + S22 * S22


@kernel
def through_sensitivity(at: Record, epsilon: float, f_1: float, f_2: float) -> Pair:
    """u_FB = (S^T S + epsilon I)^-1 S^T f_des [N m], S at the observer's pose: `at` has it, and what fades it.

    Eq. UFB: paper, "Task-space PI control". f_des [m].
    """
    S11, S12, S21, S22 = at.S
    f_1, f_2 = attainable(at, f_1, f_2)
    H11, H12, H22 = squared(at)
    H11, H22 = H11 + epsilon, H22 + epsilon
    g_1, g_2 = S11 * f_1 + S21 * f_2, S12 * f_1 + S22 * f_2
    det = H11 * H22 - H12 * H12
    return (H22 * g_1 - H12 * g_2) / det, (H11 * g_2 - H12 * g_1) / det  # Eq. UFB
