"""What the watchdogs of the feedback look at: how far and how fast the error swings, and how far the observer is off.

Windows are exponential: a window of T seconds forgets what is older than some T, and costs one number.
"""

import math

from controller.arrays import Array, Record
from controller.kernels.compiled import kernel
from controller.kernels.memory import Control
from controller.kernels.safety.chamber_watch import chambers_follow
from controller.kernels.safety.safety import is_live

MEAN_TIME = 0.1
"""Motion slower than this is no oscillation: a mean over so long follows it [s]. A whip swings at 2 to 7 Hz."""
SWING_TIME = 0.15
"""Window of the mean square of a swing [s]: less than half a period of most whips."""
HELD_TIME = 0.4
"""The reference's mean square swing is held for so long: the arm answers it late, and rings on [s]."""


@kernel
def note_tracking(error: Array, closed: bool, control: Control) -> None:
    """Update the swings of error and reference and the windowed rms with this tick's error [m], closed loop or not.

    Means follow always, so that closing a loop is no swing; while it is open, what was seen fades. A loop that closes
    has its reference stepped from the tip to where it is: an arm that still falls, or is far off, answers that.
    Not in the paper. In place: control.state.
    """
    state, limits, dt = control.state[0], control.limits[0], control.dt
    count_off_time(error, closed, control)
    if not is_live(state.mode):
        forget_tracking(error, state)
    if not closed:
        state.error_first = error[0] ** 2 + error[1] ** 2
    slow, square, held, window = dt / MEAN_TIME, dt / SWING_TIME, dt / HELD_TIME, dt / limits.error_rms_time
    swing = swing_ref = total = 0.0
    for j in range(2):
        state.error_mean[j] += window * (error[j] - state.error_mean[j])
        if not closed:
            state.ref_slow[j], state.ref_lag[j] = state.p_ref[j] - error[j], 0.0
        swing += unsteady(j, error[j], slow, state.error_slow, state.error_lag) ** 2
        swing_ref += closed * unsteady(j, state.p_ref[j], slow, state.ref_slow, state.ref_lag) ** 2
        total += error[j] ** 2
    state.swing += square * (closed * swing - state.swing)
    state.error_square += window * (closed * total - state.error_square)
    state.error_first -= window * state.error_first
    state.swing_ref += square * (swing_ref - state.swing_ref)
    state.swing_held = max(state.swing_ref, state.swing_held * (1.0 - held))
    if chambers_follow(state):  # else it is the chambers' fault, and their watchdog's matter
        over = state.swing / (limits.swing_max**2 + limits.swing_ratio**2 * state.swing_held)
        state.swing_off = max(0.0, state.swing_off + (dt * over if over > 1.0 else -dt))


@kernel
def unsteady(j: int, x: float, share: float, mean: Array, lag: Array) -> float:
    """What of coordinate j's new value `x` is no steady motion: off its mean, and not as the mean lags behind [m].

    The mean of what moves evenly lags by speed times its time: 20 mm at 0.2 m/s, which is no swing. Not in the paper.
    In place: mean, lag.
    """
    mean[j] += share * (x - mean[j])
    lag[j] += share * (x - mean[j] - lag[j])
    return x - mean[j] - lag[j]


@kernel
def forget_tracking(error: Array, state: Record) -> None:
    """Start again from the present error: nothing swings, and the reference comes from where the tip is.

    Not in the paper. In place: state.
    """
    state.swing = state.swing_ref = state.swing_held = state.swing_off = state.error_square = 0.0
    for j in range(2):
        state.error_slow[j] = state.error_mean[j] = error[j]
        state.ref_slow[j] = state.p_ref[j] - error[j]
        state.error_lag[j] = state.ref_lag[j] = 0.0
        state.error_square += error[j] ** 2
    state.error_first = state.error_square


@kernel
def count_off_time(error: Array, closed: bool, control: Control) -> None:
    """Count the time for which a closed loop is off by more than the limit; out of reach, off the nearest point in it.

    Time within the limit counts back: a loop that swings through its reference is off most of the time, not always.
    Not in the paper. In place: control.state.off_time.
    """
    state = control.state[0]
    off = math.hypot(error[0], error[1]) > control.limits[0].error_max
    change = control.dt if off else -control.dt
    state.off_time = max(0.0, state.off_time + change) if closed else 0.0


@kernel
def note_residual(residual: float, control: Control) -> None:
    """Count the time for which the observer is off the markers by more than the limit [m]; nan, no marker: nothing.

    Not in the paper. In place: control.state.residual_off.
    """
    state, limits = control.state[0], control.limits[0]
    change = control.dt if residual > limits.residual_max else -control.dt
    state.residual_off = max(0.0, state.residual_off + change) if is_live(state.mode) else 0.0
