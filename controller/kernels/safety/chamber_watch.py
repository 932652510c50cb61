"""What the watchdog of the chambers looks at: how long the pressures have not been those that the torques ask for."""

from controller.kernels.compiled import kernel

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
def note_chambers(control, measurement, u_hat, driven):
    """Count the time [s] for which the pressures are off those of u_hat (2,) [N m]; 0 unless chambers are driven."""
    state, limits = control.state[0], control.limits[0]
    off = still = 0.0
    for j in range(2):
        p_model = u_hat[j] * control.pascal_per_torque[j]
        off = max(off, abs(measurement.pressures[2 * j] - measurement.pressures[2 * j + 1] - p_model))
        for chamber in (2 * j, 2 * j + 1):
            asked = max(p_model if chamber == 2 * j else -p_model, 0.0)
            note_reading(control, chamber, measurement.pressures[chamber], asked, driven)
            still = max(still, state.chamber_still[chamber])
    change = control.dt if off > limits.pressure_off_max else -FADES * control.dt
    state.pressure_off = max(0.0, state.pressure_off + change) if driven else 0.0
    state.pressure_still = still


@kernel
def note_reading(control, chamber, shown, asked, driven):
    """Count the time [s] for which a reading stands still and is off what is asked, which has moved since [Pa]."""
    state, bound = control.state[0], STILL * control.limits[0].pressure_off_max
    if not driven or not abs(shown - state.chamber_shown[chamber]) <= STIRS:
        state.chamber_shown[chamber], state.chamber_asked[chamber] = shown, asked
        state.chamber_still[chamber] = 0.0
    elif min(abs(asked - shown), abs(asked - state.chamber_asked[chamber])) > bound:
        state.chamber_still[chamber] += control.dt


@kernel
def chambers_broken(state, limits):
    """Whether one has been off, or has stood still, for too long."""
    return state.pressure_off > limits.pressure_off_time or state.pressure_still > STILL * limits.pressure_off_time


@kernel
def chambers_follow(state):
    """Whether nothing speaks against any of them."""
    return state.pressure_off == 0.0 and state.pressure_still == 0.0
