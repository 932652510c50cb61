"""Feedforward torque u_ff and the reference p_ref that belongs to it: p_ref is always in reach, and continuous."""

import math

from controller.arrays import Array, Pair, Record
from controller.kernels.compiled import kernel
from controller.kernels.control.follow import anchor
from controller.kernels.control.inverse import REFINE_STEPS, TOLERANCE, keep_branch, refine
from controller.kernels.memory import Control
from controller.kernels.model.polygon import nearest_admissible
from controller.kernels.model.sensitivity import expand_tip
from controller.kernels.model.statics import static_tip
from controller.kernels.safety.safety import FAULT, FOLLOW, REST, TRACK, is_live
from controller.schema.modes import Law

OPEN_LOOP = int(Law.OPEN_LOOP)
BLEND_MARGIN, BLEND_MARGIN_AT_GOAL = 3e-3, 5e-4
"""If its branch leaves the wish further off, on the way or at the goal, u_ff goes to the goal's branch [m]."""


@kernel
def feed_forward(settings: Record, due: bool, control: Control) -> None:
    """Set u_ff, p_ref and p_ref_dot for this tick (paper, "Quasi-Static Feedforward Control").

    In place: control.state.
    """
    state = control.state[0]
    if is_live(state.mode) and settings.law != OPEN_LOOP:
        if state.blending:
            change_branch(settings, control)
        elif due:
            solve_inverse(settings, control)
        place_reference(control)
    else:
        lead(settings, control)


@kernel
def solve_inverse(settings: Record, control: Control) -> None:
    """One update of the static inverse of the wish, warm-started on the present branch.

    A planned row that names its torques is solved from those. Where the branch ends short of the wish, a blend to the
    goal's branch begins. In FOLLOW the rate of u_ff is limited: near a fold the inverse moves infinitely faster than
    the wish. Paper, "Quasi-Static Feedforward Control"; branches and rates are not in the paper.
    In place: control.state.
    """
    state = control.state[0]
    smap, wish = control.smap, (state.wish[0], state.wish[1])
    if state.mode == TRACK and state.guided:
        begin = (state.u_goal[0], state.u_goal[1])
        u1, u2, distance, settled = refine(smap, wish, begin, REFINE_STEPS, control.scratch)
    else:
        u1, u2, distance, settled = keep_branch(smap, wish, (state.u_ff[0], state.u_ff[1]), control.scratch)
    step = control.controller[0].torque_rate_max * max(settings.feedforward_period, control.dt)
    if state.mode == TRACK:
        step = math.inf
    state.reached = distance < TOLERANCE and max(abs(u1 - state.u_ff[0]), abs(u2 - state.u_ff[1])) <= step
    apart = max(abs(state.u_goal[0] - u1), abs(state.u_goal[1] - u2))
    at_goal = state.wish[0] == state.p_goal[0] and state.wish[1] == state.p_goal[1]
    if settled and distance > (BLEND_MARGIN_AT_GOAL if at_goal else BLEND_MARGIN) and apart > 0.0:
        state.blending, state.blend_rate = 1, 0.0
        return
    state.u_ff[0], state.u_ff[1] = towards(state.u_ff, u1, u2, step)
    if state.reached and at_goal:
        state.u_goal[0], state.u_goal[1] = state.u_ff[0], state.u_ff[1]


@kernel
def towards(u: Array, u1: float, u2: float, step: float) -> Pair:
    """The point on the way from u to (u1, u2) at most `step` further in the larger component [N m].

    Not in the paper, which bounds no rate.
    """
    apart = max(abs(u1 - u[0]), abs(u2 - u[1]))
    if apart <= step:
        return u1, u2
    return u[0] + (u1 - u[0]) * step / apart, u[1] + (u2 - u[1]) * step / apart


@kernel
def change_branch(settings: Record, control: Control) -> None:
    """Move u_ff straight to u_goal, the change of branch: bounded rate of u, and bounded speed of the static tip.

    Not in the paper, whose inverse has one branch. In place: control.state.
    """
    state, dt = control.state[0], control.dt
    d1, d2 = state.u_goal[0] - state.u_ff[0], state.u_goal[1] - state.u_ff[1]
    apart = max(abs(d1), abs(d2))
    at = expand_tip(control.smap.statics, state.u_ff[0], state.u_ff[1], control.scratch)
    gain = math.hypot(at.x_1 * d1 + at.x_2 * d2, at.y_1 * d1 + at.y_2 * d2) / max(apart, 1e-12)
    gain = max(gain, 1.0)
    change = settings.acceleration_max / gain
    rate = min(state.blend_rate + change * dt, control.controller[0].torque_rate_max, settings.speed_max / gain)
    state.blend_rate = min(rate, change * dt + math.sqrt(2.0 * change * apart))
    state.u_ff[0], state.u_ff[1] = towards(state.u_ff, state.u_goal[0], state.u_goal[1], state.blend_rate * dt)
    state.blending = state.u_ff[0] != state.u_goal[0] or state.u_ff[1] != state.u_goal[1]
    state.reached = 0
    if not state.blending:
        state.wish[0], state.wish[1] = static_tip(control.smap.statics, state.u_ff[0], state.u_ff[1], control.scratch)
        state.wish_dot[0] = state.wish_dot[1] = 0.0


@kernel
def place_reference(control: Control) -> None:
    """p_ref is the wish where u_ff reaches it, else the static tip of u_ff; its rate counts only where it is smooth.

    p_ref' of the velocity feedforward: paper, "Task-space PI control". In place: control.state.
    """
    state = control.state[0]
    x, y = state.wish[0], state.wish[1]
    if not state.reached:
        x, y = static_tip(control.smap.statics, state.u_ff[0], state.u_ff[1], control.scratch)
    smooth = state.reached or state.blending
    state.p_ref_dot[0] = (x - state.p_ref[0]) / control.dt if smooth else 0.0
    state.p_ref_dot[1] = (y - state.p_ref[1]) / control.dt if smooth else 0.0
    state.p_ref[0], state.p_ref[1] = x, y


@kernel
def lead(settings: Record, control: Control) -> None:
    """Where u leads and the reference is its static tip: vented, on the way to rest, open loop.

    An open loop moves only in FOLLOW, like everything else that an operator moves. Not in the paper: safety.
    In place: control.state.
    """
    state, bounds, dt = control.state[0], control.controller[0], control.dt
    if state.mode == REST or state.mode == FAULT:
        state.u_ff[0], state.u_ff[1] = towards(state.u, 0.0, 0.0, bounds.rest_rate * dt)
    elif is_live(state.mode):
        step = bounds.torque_rate_max * dt if state.mode == FOLLOW else 0.0
        u1, u2 = nearest_admissible(control.smap.polygon, settings.u_open[0], settings.u_open[1])
        state.u_ff[0], state.u_ff[1] = towards(state.u, u1, u2, step)
    else:
        state.u_ff[0] = state.u_ff[1] = 0.0
    state.p_ref[0], state.p_ref[1] = static_tip(control.smap.statics, state.u_ff[0], state.u_ff[1], control.scratch)
    state.p_ref_dot[0] = state.p_ref_dot[1] = 0.0
    anchor(state)
    state.reached = 0  # of a wish that moves on when the loop is closed u_ff knows nothing before it is solved
