"""How a live mode begins: where the arm is, with the torques that were in force.

Not in the paper, whose arm is armed at rest. The model's rest is elsewhere than a real arm's by all that the model has
not (set, creep, a camera off by a degree): an arm that is armed would go there, unasked.
"""

from controller.arrays import Pair, Record
from controller.kernels.compiled import kernel
from controller.kernels.control.inverse import SEARCH_STEPS, TOLERANCE, refine
from controller.kernels.memory import Control
from controller.kernels.model.statics import static_tip
from controller.kernels.observer.observer import TIP
from controller.kernels.safety.safety import speed_of
from controller.schema.modes import Law

FF = int(Law.FF)
STILL = 0.05
"""A tip that is faster swings, and where it is tells nothing of what holds it [m/s]."""


@kernel
def begin(settings: Record, telemetry: Record, control: Control) -> None:
    """Let the reference of a live mode that begins stand where the tip is fed back from, and u_ff be its inverse.

    Under a law that feeds nothing back, without a marker, or while the arm swings, it stays the static tip of the
    torques in force. In place: control.state.
    """
    state = control.state[0]
    if not state.begins or not feeds_back(settings) or state.used == 0 or speed_of(control.v) > STILL:
        return
    tip = tip_fed_back(state.used, telemetry)
    u1, u2, distance, _ = refine(control.smap, tip, (state.u_ff[0], state.u_ff[1]), SEARCH_STEPS, control.scratch)
    if distance >= TOLERANCE:
        tip = static_tip(control.smap.statics, u1, u2, control.scratch)
    state.u_ff[0], state.u_ff[1] = u1, u2
    state.p_ref[0], state.p_ref[1] = tip


@kernel
def feeds_back(settings: Record) -> bool:
    """Whether the law feeds back the error of a tip that is to be seen."""
    return settings.law > FF and settings.sensed != 0


@kernel
def tip_fed_back(used: int, telemetry: Record) -> Pair:
    """p_data [m] of the paper's error: the tip as measured, or its estimate where its marker is not in use."""
    if used & TIP:
        return telemetry.p_meas[0], telemetry.p_meas[1]
    return telemetry.p_hat[0], telemetry.p_hat[1]
