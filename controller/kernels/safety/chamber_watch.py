"""What the watchdog of the chambers looks at: how long the pressures have not been those that the torques ask for."""

from controller.arrays import Array, Record
from controller.kernels.compiled import kernel
from controller.kernels.memory import Control
from controller.kernels.model.pneumatics import chamber_pressure

FADES = 0.5
"""Time in which they follow counts back half as fast: under feedback a broken one swings the arm, off by turns."""
STIRS = 2e3
"""A reading that is not further off than this from where it was stands still [Pa]."""
STILL = 0.5
"""Standing still, it needs this share of the limit, and of its time, to be taken for broken.

A healthy one always moves when its torque does: in 387 runs with gains that make the arm whip, none stood still for
more than 57 ms while it was off by half of the limit.
"""


@kernel
def note_chambers(measurement: Record, u_hat: Array, driven: bool, control: Control) -> None:
    """Count the time [s] for which the pressures are off those of u_hat (2,) [N m]; 0 unless chambers are driven.

    Not in the paper. In place: control.state.
    """
    state, limits = control.state[0], control.limits[0]
    p, slopes, off = measurement.pressures, control.pascal_per_torque, 0.0
    for one in range(0, 4, 2):
        asked = chamber_pressure(u_hat, slopes, one) - chamber_pressure(u_hat, slopes, one + 1)
        off = max(off, abs(p[one] - p[one + 1] - asked))
    for chamber in range(p.shape[0]):
        note_reading(chamber, p[chamber], chamber_pressure(u_hat, slopes, chamber), driven, control)
    change = control.dt if off > limits.pressure_off_max else -FADES * control.dt
    state.pressure_off = max(0.0, state.pressure_off + change) if driven else 0.0


@kernel
def note_reading(chamber: int, shown: float, asked: float, driven: bool, control: Control) -> None:
    """Count the time [s] for which a reading stands still and is off what is asked, which has moved since [Pa].

    Not in the paper. In place: control.state.
    """
    state, bound = control.state[0], STILL * control.limits[0].pressure_off_max
    if not driven or not abs(shown - state.chamber_shown[chamber]) <= STIRS:
        state.chamber_shown[chamber], state.chamber_asked[chamber] = shown, asked
        state.chamber_still[chamber] = 0.0
    elif min(abs(asked - shown), abs(asked - state.chamber_asked[chamber])) > bound:
        state.chamber_still[chamber] += control.dt


@kernel
def chambers_broken(state: Record, limits: Record) -> bool:
    """Whether one has been off, or has stood still, for too long. Not in the paper."""
    return state.pressure_off > limits.pressure_off_time or longest_still(state) > STILL * limits.pressure_off_time


@kernel
def chambers_follow(state: Record) -> bool:
    """Whether nothing speaks against any of them. Not in the paper."""
    return state.pressure_off == 0.0 and longest_still(state) == 0.0


@kernel
def longest_still(state: Record) -> float:
    """The most of the times for which a reading has stood still [s]. Not in the paper."""
    longest = 0.0
    for chamber in range(state.chamber_still.shape[0]):
        longest = max(longest, state.chamber_still[chamber])
    return longest
