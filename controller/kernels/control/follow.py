"""The reference: from the operator's target or the planned rows to a wish that moves within its limits."""

import math

from controller.arrays import Pair, Record
from controller.kernels.compiled import kernel
from controller.kernels.control.inverse import (
    MARGIN,
    REFINE_STEPS,
    STARTS,
    TOLERANCE,
    keep_branch,
    other_branch,
    refine,
)
from controller.kernels.control.timing import feedforward_ticks
from controller.kernels.memory import Control
from controller.kernels.model.statics import static_tip
from controller.kernels.safety.safety import FOLLOW, HOLD, TRACK, move
from controller.schema.modes import Cause, RowKind

SEARCH_EVERY = 10
"""Least ticks between two looks at another branch, which costs as much as the rest of the tick."""
HELD_M, HELD_S, MARGIN_MOVING = 2e-3, 0.3, 30e-3
"""A goal that stays within HELD_M [m] for HELD_S [s] is gone to in whichever pose comes nearest; one that moves on may
soon be back in the reach of the present pose: for it only a branch that is nearer by MARGIN_MOVING [m] is taken."""
DRAWN = int(RowKind.DRAWN)
REFERENCE_DONE = int(Cause.REFERENCE_DONE)


@kernel
def refer(command: Record, due: bool, control: Control) -> None:
    """Set the goal and move the wish for this tick; in any other mode than FOLLOW and TRACK the wish stays.

    p_ref: paper, "Task 5: Real-Time User-Defined Tracking". In place: control.state.
    """
    state = control.state[0]
    if state.entered:
        anchor(state)
        state.index = state.followed = 0
    if state.mode == FOLLOW:
        if due:
            aim(command.target[0], command.target[1], feedforward_ticks(command.settings, control.dt), control)
        approach_goal(command.settings, control.dt, state)
    elif state.mode == TRACK:
        follow_plan(control)
    if state.mode != TRACK:  # also where the plan has just come to its end
        state.kind, state.guided = DRAWN, 0


@kernel
def anchor(state: Record) -> None:
    """Let the wish stand where the reference is, on the branch on which u_ff is. Not in the paper. In place: state."""
    state.blending, state.blend_rate = 0, 0.0
    state.reachable = state.reached = 1
    for j in range(2):
        state.wish[j] = state.p_goal[j] = state.p_ref[j]
        state.wish_dot[j] = 0.0
        state.u_goal[j] = state.u_ff[j]


@kernel
def aim(x: float, y: float, every: int, control: Control) -> None:
    """Project the goal (x, y) [m] into the reach: u_goal, and p_goal, the goal itself where it can be reached.

    It is called at the multiples of `every` ticks, and at some of them looks at one other branch, at each in turn.
    Paper, "Task 5: Real-Time User-Defined Tracking": projected onto the workspace. In place: control.state.
    """
    state, smap = control.state[0], control.smap
    note_aim(x, y, control.dt, state)
    u1, u2, distance, settled = keep_branch(smap, (x, y), (state.u_goal[0], state.u_goal[1]), control.scratch)
    found = (u1, u2, distance)
    rank = branch_due(state.tick, every)
    if settled and distance >= TOLERANCE and rank >= 0:
        margin = MARGIN if state.aimed_time >= HELD_S else MARGIN_MOVING
        found = other_branch(smap, (x, y), found, margin, rank, control.scratch)
    set_goal((x, y), found, control)


@kernel
def branch_due(tick: int, every: int) -> int:
    """Which other branch is looked at in this tick, where goals are set at the multiples of `every` ticks; -1: none.

    From look to look it is the fewest multiple of `every` that SEARCH_EVERY allows: so each branch has its turn. Not in
    the paper.
    """
    apart = (SEARCH_EVERY + every - 1) // every * every
    return tick // apart % STARTS if tick % apart == 0 else -1


@kernel
def note_aim(x: float, y: float, dt: float, state: Record) -> None:
    """Count the ticks for which the goal (x, y) [m] has stood still, in seconds. Not in the paper.

    In place: state.aimed, state.aimed_tick, state.aimed_time.
    """
    if math.hypot(x - state.aimed[0], y - state.aimed[1]) > HELD_M:
        state.aimed[0], state.aimed[1] = x, y
        state.aimed_tick = state.tick
    state.aimed_time = (state.tick - state.aimed_tick) * dt


@kernel
def set_goal(target: Pair, found: tuple[float, float, float], control: Control) -> None:
    """Take over u_goal and the distance [m] that it leaves to `target` (x, y) [m]; p_goal is where they lead.

    Paper, "Task 5: Real-Time User-Defined Tracking". In place: control.state.
    """
    state = control.state[0]
    state.u_goal[0], state.u_goal[1] = found[0], found[1]
    state.reachable = found[2] < TOLERANCE
    if not state.reachable:
        target = static_tip(control.smap.statics, found[0], found[1], control.scratch)
    state.p_goal[0], state.p_goal[1] = target


@kernel
def approach_goal(settings: Record, dt: float, state: Record) -> None:
    """Move the wish towards p_goal for one tick, unless u_ff is on its way to another branch: then the wish waits.

    Not in the paper, whose live reference has no limits. In place: state.
    """
    if state.blending:
        return
    brake(settings, state)
    p, v = limit_motion(
        (state.wish[0], state.wish[1]),
        (state.wish_dot[0], state.wish_dot[1]),
        (state.p_goal[0], state.p_goal[1]),
        (settings.speed_max, state.acceleration),
        dt,
    )
    state.wish[0], state.wish[1] = p
    state.wish_dot[0], state.wish_dot[1] = v


@kernel
def brake(settings: Record, state: Record) -> None:
    """Take over the limit of acceleration; a lower one only when the wish can still stop at its goal under it.

    Not in the paper: see `approach_goal`. In place: state.acceleration.
    """
    a, speed = settings.acceleration_max, math.hypot(state.wish_dot[0], state.wish_dot[1])
    distance = math.hypot(state.p_goal[0] - state.wish[0], state.p_goal[1] - state.wish[1])
    if a >= state.acceleration or speed * speed <= 2.0 * a * distance:
        state.acceleration = a


@kernel
def limit_motion(p: Pair, v: Pair, goal: Pair, limits: Pair, dt: float) -> tuple[Pair, Pair]:
    """Position [m] and velocity [m/s] after dt of the fastest motion to `goal` within speed and acceleration `limits`.

    The speed is the highest from which it can still stop at the goal: v dt / 2 + v^2 / (2 a) = distance.
    Not in the paper: see `approach_goal`.
    """
    speed_max, a = limits
    d_x, d_y = goal[0] - p[0], goal[1] - p[1]
    distance = math.hypot(d_x, d_y)
    speed = a * dt * (math.sqrt(0.25 + 2.0 * distance / (a * dt * dt)) - 0.5)
    speed = min(speed, speed_max, distance / dt)
    share = speed / distance if distance > 0.0 else 0.0
    c_x, c_y = share * d_x - v[0], share * d_y - v[1]
    change = math.hypot(c_x, c_y)
    if change > a * dt:
        c_x, c_y = c_x * a * dt / change, c_y * a * dt / change
    v_x, v_y = v[0] + c_x, v[1] + c_y
    return (p[0] + v_x * dt, p[1] + v_y * dt), (v_x, v_y)


@kernel
def follow_plan(control: Control) -> None:
    """Take the next row of the planned reference, which may repeat; after as many as are to be followed, HOLD.

    A row may name the torques that hold it, and is followed in that pose of the arm; else in that of the row before.
    p_ref(t): paper, "Quasi-Static Feedforward Control"; poses are not in the paper. In place: control.state.
    """
    state, plan = control.state[0], control.plan[0]
    if state.followed >= plan.ticks:
        move(HOLD, REFERENCE_DONE, state)
        anchor(state)
        return
    x, y = control.reference[state.index, 0], control.reference[state.index, 1]
    u1, u2 = control.guide[state.index, 0], control.guide[state.index, 1]
    state.guided = math.isfinite(u1) and math.isfinite(u2)
    if state.guided:
        u1, u2, distance, _ = refine(control.smap, (x, y), (u1, u2), REFINE_STEPS, control.scratch)
        set_goal((x, y), (u1, u2, distance), control)
    else:
        aim(x, y, 1, control)
    state.kind = control.kinds[state.index]
    state.row = state.planned_row = state.index
    if state.followed >= plan.rows and plan.rows + state.index - plan.again < control.slot.planned.shape[0]:
        state.planned_row = plan.rows + state.index - plan.again
    state.followed += 1
    state.index += 1
    if state.index == plan.rows:
        state.index = plan.again
    for j in range(2):
        state.wish_dot[j] = (state.p_goal[j] - state.wish[j]) / control.dt
        state.wish[j] = state.p_goal[j]
