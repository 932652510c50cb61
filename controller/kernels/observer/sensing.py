"""The markers: the newest sample, which of them are usable, and whether they move as an arm can."""

import math

from controller.kernels.compiled import kernel
from controller.kernels.safety.safety import is_live, speed_of

WHIP = 2.0
"""Faster than this an arm whips [m/s], at a step or a start from straight: what it does within 10 ms is no jump."""
WHIP_TIME = 0.1
"""Time constant with which it comes to rest after that [s]."""


@kernel
def sense(control, sensing, observer, t_ns, settings, measurement):
    """Take over a new sample and note which of the switched-on sensors are usable now, as bits in `used`."""
    state = control.state[0]
    usable = 0
    if measurement.t_ns > sensing.sample_ns[0]:
        drop_jumps(control, sensing, observer.points, measurement)
        note_motion(state, sensing, observer.u_hat, measurement)
        take_sample(sensing, measurement, state.jumped)
        state.jumped &= settings.sensed
    for i in range(sensing.p.shape[0]):
        if settings.sensed >> i & 1 and math.isfinite(sensing.p[i, 0] + sensing.p[i, 1]):
            usable |= 1 << i
    if usable != 0 or settings.sensed == 0:
        state.seen_ns = sensing.sample_ns[0]
    fresh = sensing.sample_ns[0] > 0 and (t_ns - sensing.sample_ns[0]) * 1e-9 <= control.limits[0].measurement_old
    state.used = usable if fresh else 0
    carried = fresh and control.controller[0].carry_on
    sensing.age[0] = (t_ns - sensing.sample_ns[0]) * 1e-9 if carried else 0.0


@kernel
def drop_jumps(control, sensing, points, measurement):
    """Find the markers that are neither where their own motion nor where the model's, `points`, would have led them.

    The distance from those, (10,2) [m], is compared with that when the marker was last used, so a constant error of the
    model does not count. A marker that jumped is used again once it jumped back, was out of sight, or the rig stopped:
    without it the model drifts, in time by as much as the marker is off.
    """
    state, limits = control.state[0], control.limits[0]
    state.jumped = 0
    whip = max(0.0, fastest(control, sensing, measurement) - WHIP)
    for i in range(points.shape[0]):
        x, y = measurement.markers[i, 0] - points[i, 0], measurement.markers[i, 1] - points[i, 1]
        if math.isfinite(x + y):
            since = (measurement.t_ns - sensing.met_ns[i]) * 1e-9
            sensing.met_ns[i] = measurement.t_ns
            room = limits.jump_max + (limits.jump_speed + 2.0 * whip) * since
            steady = off_course(sensing, measurement, i, since) <= room  # nan, not seen in the last sample: no
            dropped = math.isnan(sensing.p[i, 0]) and math.isfinite(sensing.seen[i, 0])
            apart = math.hypot(x - sensing.off[i, 0], y - sensing.off[i, 1]) > room
            back = not steady or whip > 0.0
            if is_live(state.mode) and ((dropped and not back) or (apart and (dropped or not steady))):
                state.jumped |= 1 << i
            else:
                sensing.off[i, 0], sensing.off[i, 1] = x, y
        sensing.seen[i, 0], sensing.seen[i, 1] = measurement.markers[i, 0], measurement.markers[i, 1]


@kernel
def fastest(control, sensing, measurement):
    """The highest speed lately, of any marker or of the model's tip [m/s]."""
    fast = sensing.fast[0] * math.exp(-(measurement.t_ns - sensing.sample_ns[0]) * 1e-9 / WHIP_TIME)
    fast = max(fast, speed_of(control.v))
    for i in range(sensing.v.shape[0]):
        fast = max(fast, math.hypot(sensing.v[i, 0], sensing.v[i, 1]))
    sensing.fast[0] = fast
    return fast


@kernel
def off_course(sensing, measurement, i, since):
    """How far marker i is from where its own motion had led it, `since` [s] after it was seen last [m]."""
    x = measurement.markers[i, 0] - sensing.seen[i, 0] - sensing.v[i, 0] * since
    return math.hypot(x, measurement.markers[i, 1] - sensing.seen[i, 1] - sensing.v[i, 1] * since)


@kernel
def note_motion(state, sensing, u_hat, measurement):
    """Remember when any marker last moved, and the torque on the model then: no camera repeats all its numbers."""
    for i in range(sensing.p.shape[0]):
        for j in range(2):
            x = measurement.markers[i, j]
            if x == x and x != sensing.p[i, j]:  # nan is no motion
                state.moved_ns = measurement.t_ns
                state.u_moved[0], state.u_moved[1] = u_hat[0], u_hat[1]
                return


@kernel
def take_sample(sensing, measurement, jumped):
    """Hold the markers of `measurement`, but for those in `jumped`, and their velocity since the sample before."""
    rate = 1e9 / (measurement.t_ns - sensing.sample_ns[0])
    for i in range(sensing.p.shape[0]):
        for j in range(2):
            p = measurement.markers[i, j] if not jumped >> i & 1 else math.nan
            v = (p - sensing.p[i, j]) * rate
            sensing.v[i, j] = v if math.isfinite(v) and sensing.sample_ns[0] > 0 else 0.0
            sensing.p[i, j] = p
    sensing.sample_ns[0] = measurement.t_ns
