"""How a live mode begins: where the arm is, with the torques that were in force.

Not in the paper, whose arm is armed at rest. The model's rest is elsewhere than a real arm's by all that the model has
not (set, creep, a camera off by a degree): an arm that is armed would go there, unasked.
"""

import math

from controller.arrays import Pair, Record
from controller.kernels.compiled import kernel
from controller.kernels.control.task_space import through_sensitivity, update_sensitivity
from controller.kernels.memory import Control, Sensing
from controller.kernels.model.polygon import nearest_admissible
from controller.kernels.model.statics import static_tip
from controller.kernels.observer.observer import TIP
from controller.kernels.observer.sensing import marker_speed
from controller.kernels.safety.safety import speed_of
from controller.schema.modes import Law

FF = int(Law.FF)
STILL = 0.05
"""A tip that is faster swings, and where it is tells nothing of what holds it [m/s]."""
SETTLING, FALLING = 0.1, 0.2
"""For so long after CLEAR [s] the model, which starts again at rest, is slower than the arm; then a marker that is
faster than this falls [m/s]: its speed by two samples is too noisy to be asked of it always."""
THERE, STEPS = 5e-4, 4
"""A tip as near to where the model has it [m] is there; steps in which the reference comes to one that is not."""


@kernel
def begin(settings: Record, telemetry: Record, sensing: Sensing, control: Control) -> None:
    """Let the reference of a live mode that begins stand where the tip is fed back from, and u_ff be its inverse.

    The inverse is that of the least change of torque: straight, an arm has two for each tip beside it, and noise would
    choose. Under a law that feeds nothing back, without a marker, or while the arm swings, the reference stays the
    static tip of the torques in force. Not in the paper. In place: control.
    """
    state, smap = control.state[0], control.smap
    if not state.begins or not feeds_back(settings) or state.used == 0 or swings(sensing, control):
        return
    x, y = tip_fed_back(state.used, telemetry)
    if math.hypot(x - state.p_ref[0], y - state.p_ref[1]) < THERE:
        return
    update_sensitivity(control)
    u_1, u_2 = state.u_ff
    for _ in range(STEPS):
        d_1, d_2 = through_sensitivity(state, control.controller[0].epsilon, x - state.p_ref[0], y - state.p_ref[1])
        u_1, u_2 = nearest_admissible(smap.polygon, u_1 + d_1, u_2 + d_2)
        state.p_ref[0], state.p_ref[1] = static_tip(smap.statics, u_1, u_2, control.scratch)
    state.u_ff[0], state.u_ff[1] = u_1, u_2


@kernel
def swings(sensing: Sensing, control: Control) -> bool:
    """Whether the arm moves too fast for its place to tell what holds it. Not in the paper."""
    state = control.state[0]
    settling = (state.last_ns - state.forgot_ns) * 1e-9 < SETTLING
    return speed_of(control.v) > STILL or (settling and marker_speed(sensing) > FALLING)


@kernel
def feeds_back(settings: Record) -> bool:
    """Whether the law feeds back the error of a tip that is to be seen. Not in the paper."""
    return settings.law > FF and settings.sensed != 0


@kernel
def tip_fed_back(used: int, telemetry: Record) -> Pair:
    """p_data [m] of the error: the tip as measured, or its estimate where its marker is not in use.

    Paper, "Task-space PI control".
    """
    if used & TIP:
        return telemetry.p_meas[0], telemetry.p_meas[1]
    return telemetry.p_hat[0], telemetry.p_hat[1]
