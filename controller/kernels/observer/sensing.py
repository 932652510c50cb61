"""The markers: the newest sample, which of them are usable, and whether they move as an arm can."""

import math

from controller.arrays import Array, Record
from controller.kernels.compiled import kernel
from controller.kernels.memory import Control, Sensing
from controller.kernels.observer.observer import Observer
from controller.kernels.observer.reseat import is_moved_over
from controller.kernels.safety.safety import is_live, speed_of

WHIP = 2.0
"""Faster than this an arm whips [m/s], at a step or a start from straight: what it does within 10 ms is no jump."""
WHIP_TIME = 0.1
"""Time constant with which it comes to rest after that [s]."""
TOGETHER = 0.25
"""A sample that follows another within this share of the usual time came together with it."""
ADAPTING = 1.02
"""The usual time goes up or down by this factor at most from sample to sample: gaps and bursts hardly move it."""


@kernel
def sense(
    observer: Observer, t_ns: int, settings: Record, measurement: Record, control: Control, sensing: Sensing
) -> None:
    """Take over a new sample and note which of the switched-on sensors are usable now, as bits in `used`.

    Any subset of rods: paper, "Task 4: Reduced Sensing". Age and plausibility are not in the paper.
    In place: control.state, sensing.
    """
    state = control.state[0]
    usable = 0
    if measurement.t_ns > sensing.sample_ns[0]:
        note_motion(sensing, observer.u_hat, measurement, state)
        note_interval(measurement, sensing)
        drop_jumps(observer.points, measurement, control, sensing)
        take_sample(measurement, sensing)
        state.jumped = sensing.dropped[0] & settings.sensed
    for i in range(sensing.p.shape[0]):
        if settings.sensed >> i & 1 and math.isfinite(sensing.p[i, 0] + sensing.p[i, 1]):
            usable |= 1 << i
    if usable != 0 or settings.sensed == 0:
        state.seen_ns = sensing.sample_ns[0]
    fresh = sensing.sample_ns[0] > 0 and (t_ns - sensing.sample_ns[0]) * 1e-9 <= control.limits[0].measurement_old
    state.moved_over = is_moved_over(observer.seat)
    state.used = usable if fresh and not state.moved_over else 0
    carried = fresh and control.controller[0].carry_on
    sensing.age[0] = (t_ns - sensing.sample_ns[0]) * 1e-9 + 0.5 * control.dt if carried else 0.0


@kernel
def note_interval(measurement: Record, sensing: Sensing) -> None:
    """Note for how long the new sample may have been held back on its way; 0 unless it came together with the last.

    Without times of capture a source's samples are stamped as they arrive, those that were held back all at once: the
    time between them tells no speed, and the arm has moved as in the gap before them. The one after them was captured
    no sooner after the last of them than is usual, which is about the median.
    Not in the paper. In place: sensing.usual, sensing.gap, sensing.held, sensing.late.
    """
    apart = (measurement.t_ns - sensing.sample_ns[0]) * 1e-9
    if apart < TOGETHER * sensing.usual[0]:
        sensing.held[0], sensing.late[0] = sensing.gap[0], 0.0
    else:
        sensing.late[0] = max(0.0, sensing.usual[0] - apart) if sensing.held[0] > 0.0 else 0.0
        sensing.gap[0], sensing.held[0] = apart, 0.0
    sensing.usual[0] = min(max(apart, sensing.usual[0] / ADAPTING), sensing.usual[0] * ADAPTING)


@kernel
def drop_jumps(points: Array, measurement: Record, control: Control, sensing: Sensing) -> None:
    """Find the markers that are neither where their own motion nor where the model's, `points`, would have led them.

    The distance from those, (10,2) [m], is compared with that when the marker was last used, so a constant error of the
    model does not count. A marker that jumped is used again once it jumped back, was out of sight for long, or the rig
    stopped: without it the model drifts, in time by as much as the marker is off. Not in the paper: safety.
    In place: sensing.
    """
    limits, live = control.limits[0], is_live(control.state[0].mode)
    whip = max(0.0, top_speed(control, measurement, sensing) - WHIP)
    for i in range(points.shape[0]):
        since = (measurement.t_ns - sensing.met_ns[i]) * 1e-9
        if sensing.met_ns[i] < sensing.sample_ns[0] and since > limits.measurement_old:
            forget_jump(i, sensing)
        x, y = measurement.markers[i, 0] - points[i, 0], measurement.markers[i, 1] - points[i, 1]
        if math.isfinite(x + y):
            room = limits.jump_max + (limits.jump_speed + 2.0 * whip) * (since + sensing.held[0])
            steady = off_course(sensing, measurement, i, since) <= room  # nan, its course is unknown: no
            apart = math.hypot(x - sensing.off[i, 0], y - sensing.off[i, 1]) > room
            dropped = sensing.dropped[0] >> i & 1 != 0
            back = not steady or whip > 0.0
            jumped = live and ((dropped and not back) or (apart and (dropped or not steady)))
            note_course(measurement, i, 0.0 if dropped or jumped else 1.0 / (since + sensing.late[0]), sensing)
            if jumped:
                sensing.dropped[0] |= 1 << i
            else:
                sensing.dropped[0] &= ~(1 << i)
                sensing.off[i, 0], sensing.off[i, 1] = x, y


@kernel
def forget_jump(i: int, sensing: Sensing) -> None:
    """Judge marker i again, by the model alone, if it jumped: it is out of sight.

    Not in the paper: see `drop_jumps`. In place: sensing.dropped, sensing.seen.
    """
    if sensing.dropped[0] >> i & 1:
        sensing.dropped[0] &= ~(1 << i)
        sensing.seen[i, 0] = sensing.seen[i, 1] = math.nan


@kernel
def note_course(measurement: Record, i: int, rate: float, sensing: Sensing) -> None:
    """Remember where marker i is seen, and how fast it got there: `rate` [1/s] times the way since it was seen last.

    A sample that may have been held back tells no speed other than 0: the last one stays.
    Not in the paper: see `drop_jumps`. In place: sensing.seen, sensing.seen_dot, sensing.met_ns.
    """
    for j in range(2):
        if sensing.held[0] == 0.0 or rate == 0.0:
            v = (measurement.markers[i, j] - sensing.seen[i, j]) * rate
            sensing.seen_dot[i, j] = v if math.isfinite(v) else 0.0
        sensing.seen[i, j] = measurement.markers[i, j]
    sensing.met_ns[i] = measurement.t_ns


@kernel
def top_speed(control: Control, measurement: Record, sensing: Sensing) -> float:
    """The highest speed lately, of any marker or of the model's tip [m/s]. Not in the paper. In place: sensing.fast."""
    fast = sensing.fast[0] * math.exp(-(measurement.t_ns - sensing.sample_ns[0]) * 1e-9 / WHIP_TIME)
    sensing.fast[0] = max(fast, speed_of(control.v), marker_speed(sensing))
    return sensing.fast[0]


@kernel
def marker_speed(sensing: Sensing) -> float:
    """Speed of the fastest marker, by difference of its last two samples [m/s]. Not in the paper."""
    fast = 0.0
    for i in range(sensing.v.shape[0]):
        fast = max(fast, math.hypot(sensing.v[i, 0], sensing.v[i, 1]))
    return fast


@kernel
def off_course(sensing: Sensing, measurement: Record, i: int, since: float) -> float:
    """How far marker i is from where its own motion had led it, `since` [s] after it was seen last [m].

    Not in the paper: see `drop_jumps`.
    """
    x = measurement.markers[i, 0] - sensing.seen[i, 0] - sensing.seen_dot[i, 0] * since
    return math.hypot(x, measurement.markers[i, 1] - sensing.seen[i, 1] - sensing.seen_dot[i, 1] * since)


@kernel
def note_motion(sensing: Sensing, u_hat: Array, measurement: Record, state: Record) -> None:
    """Remember when any marker last moved, and the torque on the model then: no camera repeats all its numbers.

    A marker has moved that is not where it was seen last, used or not. Out of sight it has not, nor if it is seen
    again where it was. Not in the paper: safety. In place: state.moved_ns, state.u_moved.
    """
    for i in range(sensing.seen.shape[0]):
        x, y = measurement.markers[i, 0], measurement.markers[i, 1]
        if math.isfinite(x + y) and (x != sensing.seen[i, 0] or y != sensing.seen[i, 1]):
            state.moved_ns = measurement.t_ns
            state.u_moved[0], state.u_moved[1] = u_hat[0], u_hat[1]
            return


@kernel
def take_sample(measurement: Record, sensing: Sensing) -> None:
    """Hold the markers of `measurement`, but for those that jumped, and their velocity since the sample before.

    The velocity of the sample before stays where this one came together with it: see `note_interval`.
    p_data and its rate: paper, "Dynamic observer". In place: sensing.p, sensing.v, sensing.sample_ns.
    """
    rate = 1e9 / (measurement.t_ns - sensing.sample_ns[0] + 1e9 * sensing.late[0])
    for i in range(sensing.p.shape[0]):
        for j in range(2):
            p = measurement.markers[i, j] if not sensing.dropped[0] >> i & 1 else math.nan
            if sensing.held[0] == 0.0:
                v = (p - sensing.p[i, j]) * rate
                sensing.v[i, j] = v if math.isfinite(v) and sensing.sample_ns[0] > 0 else 0.0
            sensing.p[i, j] = p
    sensing.sample_ns[0] = measurement.t_ns
