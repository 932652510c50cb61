"""From a drawing, or a name of the library, to the reference that a run or a preview follows."""

from dataclasses import dataclass, replace

import numpy as np

from controller.arrays import Array
from controller.assembly.statics import static_map
from controller.errors import ParameterError
from controller.kernels.model.statics import StaticMap
from controller.reference import library
from controller.reference.drawn import resampled
from controller.reference.feasible.bounds import Limits
from controller.reference.feasible.course import Course, course
from controller.reference.feasible.from_rest import leaving_rest
from controller.reference.feasible.smoothing import smoothed
from controller.reference.feasible.strokes import one_after_another
from controller.reference.feasible.timing import APART, fastest, steady
from controller.reference.feasible.travel import Pose, rest, travel
from controller.reference.feasible.within_limits import Followed, within_limits
from controller.reference.feasible.within_reach import is_rest
from controller.reference.path_file import read_samples
from controller.reference.reference import Reference
from controller.reference.shapes import lengths
from controller.schema.parameters import RigParameters, Settings
from controller.simulation.live_path import LIVE_PATH_FILE
from server.drawing.messages import DURATION_MAX, DURATION_MIN, DrawingBody, Duration, Fastest, Given, Speed, Wanted
from server.drawing.references import TITLES, known
from server.drawing.strokes import length_of, strokes_of

LENGTH_MIN = 1e-3
"""A drawing is at least so long [m]."""
SPEED_MAX = 1.0
"""No constant speed is above this [m/s]."""
ROUND = 1e-4
"""Corners are rounded by this at least where the speed depends on the curvature [m]; a marker's noise is as much."""

ALMOST = 0.995
"""Of the limits is asked for: a lap leaves its last row out, which is its first, and so ends a little abruptly."""


@dataclass(frozen=True)
class Planned:
    """A drawing on its way to the rig."""

    path: Followed
    """What is followed, without the approach."""
    reference: Reference

    @property
    def outside_share(self) -> float:
        """Of the time without travel 0..1."""
        return float((self.path.distance[~self.path.travel] > 0.0).mean())

    def outside(self) -> str:
        """Which part is out of reach, "" for none."""
        if not (share := self.outside_share):
            return ""
        return f"{100 * share:.3g} % of it is out of reach, by up to {1e3 * self.path.distance.max():.3g} mm"


def planned(drawing: DrawingBody, rig: RigParameters, settings: Settings) -> Reference:
    """The reference that follows `drawing`, with the approach from rest in front, for the actuator of `rig`.

    Raises ParameterError for what cannot be timed, and for what leaves the reach if it may not be projected.
    """
    found = plan(drawing, rig, settings)
    if drawing.outside == "refuse" and (outside := found.outside()):
        raise ParameterError(f"outside = refuse: {drawing.name}: {outside}")
    return found.reference


def plan(drawing: DrawingBody, rig: RigParameters, settings: Settings) -> Planned:
    """What `drawing` becomes within the limits of `settings`, whether or not it may leave the reach.

    Raises ParameterError as `rows_of` and `within_limits` do.
    """
    dt, limits = rig.controller.dt, operator_limits(rig, settings)
    smap, wished = static_map(rig.actuator, rig.controller), rows_of(drawing, settings, rig.controller.dt)
    first, lead = led_within(smap, wished[0], limits, dt, drawing.timing.kind == "given")
    others = [within_limits(smap, stroke, limits, dt) for stroke in wished[1:]]
    path = one_after_another(smap, [first, *others], limits, dt)
    _require_time((len(path.p) - 1) * dt, "within the limits of speed, acceleration and torque rate")
    found = _course(drawing, path.p, dt) if not path.travel.any() else Course(0)
    reference = Reference(
        name=drawing.name,
        p=np.vstack([lead[0], path.p]),
        start=len(lead[0]),
        frequency=found.frequency if not found.steps else None,
        velocity_feedforward=True,  # K_FF is what the settings say
        led=len(lead[0]),
        u=np.vstack([lead[1], path.u]),
        travel=np.concatenate([np.ones(len(lead[0]), bool), path.travel]),
        axis_frequencies=found.axis_frequencies,
    )
    return Planned(path, reference)


def rig_limits(rig: RigParameters) -> Limits:
    """What the rig itself lets a planned reference do, which the paper's own references keep within."""
    bounds = rig.controller
    return Limits(bounds.reference_speed_max, bounds.reference_acceleration_max, bounds.torque_slew_max)


def led_within(
    smap: StaticMap, wished: Array, limits: Limits, dt: float, sampled: bool
) -> tuple[Followed, tuple[Array, Array]]:
    """The path `wished` (n, 2) [m] within reach and limits, and its approach from rest: none where it begins there."""
    if is_rest(smap, wished[0]):
        return within_limits(smap, leaving_rest(smap, wished), limits, dt, sampled), (np.empty((0, 2)),) * 2
    path = within_limits(smap, wished, limits, dt, sampled)
    return path, travel(smap, rest(smap), Pose(path.p[0], path.u[0]), limits, dt, library.APPROACH)


def operator_limits(rig: RigParameters, settings: Settings) -> Limits:
    """What an operator lets the tip do, and the rig its torques."""
    return Limits(settings.speed_max, settings.acceleration_max, rig.controller.torque_slew_max)


def wanted(body: Wanted, rig: RigParameters, settings: Settings) -> Reference:
    """The reference that `body` asks for; raises what `planned` and `named` do."""
    if body.drawing is not None:
        return planned(body.drawing, rig, settings)
    found = named(str(body.reference), rig)
    return replace(found, velocity_feedforward=found.velocity_feedforward and body.K_FF == "published")


def named(name: str, rig: RigParameters) -> Reference:
    """The reference `name`, under its title. Raises UnknownReference, and ParameterError where it is out of reach."""
    name = known(name)
    found = library.reference(name, rig.actuator, rig.controller) if name in library.PLANS else _live_path(rig)
    return replace(found, name=TITLES[name].title)


def _live_path(rig: RigParameters) -> Reference:
    """The recorded path, where this actuator reaches it, within the rig's own limits."""
    dt, smap = rig.controller.dt, static_map(rig.actuator, rig.controller)
    wished = resampled(read_samples(LIVE_PATH_FILE), dt)
    path, lead = led_within(smap, wished, rig_limits(rig), dt, sampled=True)
    return Reference(
        name="live_path",
        p=np.vstack([lead[0], path.p]),
        start=len(lead[0]),
        led=len(lead[0]),
        u=np.vstack([lead[1], path.u]),
        travel=np.concatenate([np.ones(len(lead[0]), bool), path.travel]),
    )


def rows_of(drawing: DrawingBody, settings: Settings, dt: float) -> list[Array]:
    """Rows (n, 2) [m] of each stroke of `drawing` every dt [s], smoothed and timed, neither projected nor led to.

    Raises ParameterError for a drawing that is too short, or that takes too long or too little time.
    """
    strokes = strokes_of(drawing)
    if isinstance(drawing.timing, Given):
        return [_as_given(drawing, strokes[0], dt)]
    length = length_of(strokes)
    if length < LENGTH_MIN:
        raise ParameterError(f"points: {1e3 * length:.3g} mm in all, less than {1e3 * LENGTH_MIN:g} mm")
    closed = drawing.closed and len(strokes) == 1
    strokes = [stroke for stroke in strokes if lengths(stroke)[-1] > APART]
    if isinstance(drawing.timing, Fastest):
        return _fastest([smoothed(stroke, max(drawing.smoothing, ROUND), closed) for stroke in strokes], settings, dt)
    paths = [smoothed(stroke, drawing.smoothing, closed) for stroke in strokes]
    length = length_of(paths)
    duration = _duration(drawing.timing, length)
    return [steady(path, duration * float(lengths(path)[-1]) / length, dt) for path in paths]


def _fastest(paths: list[Array], settings: Settings, dt: float) -> list[Array]:
    """Rows of each path, from rest to rest in the least time."""
    limits = Limits(settings.speed_max, settings.acceleration_max).scaled(ALMOST)
    rides = [fastest(path, limits) for path in paths]
    _require_time(sum(float(ride.t[-1]) for ride in rides), "timing.kind = fastest")
    return [ride.rows(dt) for ride in rides]


def _as_given(drawing: DrawingBody, points: Array, dt: float) -> Array:
    """Rows at the times that came with the points; smoothing moves places, not times."""
    t = np.array(drawing.times)
    _require_time(float(t[-1] - t[0]), "times")
    at = t[0] + dt * np.arange(int((t[-1] - t[0]) / dt + 1e-6) + 1)
    arc = lengths(points)
    if not drawing.smoothing or not arc[-1]:
        return np.column_stack([np.interp(at, t, points[:, j]) for j in range(2)])
    path = smoothed(points, drawing.smoothing)
    share = np.interp(at, t, arc / arc[-1]) * (len(path) - 1)
    return np.column_stack([np.interp(share, np.arange(len(path)), path[:, j]) for j in range(2)])


def _duration(timing: Speed | Duration, length: float) -> float:
    """How long a path of `length` [m] takes at constant speed [s]."""
    if isinstance(timing, Speed):
        _require_time(length / timing.speed, f"timing.speed = {timing.speed:g} m/s")
        return length / timing.speed
    speed = length / timing.duration
    if speed > SPEED_MAX:
        raise ParameterError(f"timing.duration = {timing.duration:g} s: {speed:.3g} m/s, more than {SPEED_MAX:g} m/s")
    return timing.duration


def _require_time(duration: float, what: str) -> None:
    """Raise ParameterError if a path takes too little or too much time because of `what`."""
    if not DURATION_MIN <= duration <= DURATION_MAX:
        raise ParameterError(f"{what}: the path takes {duration:.4g} s, outside [{DURATION_MIN:g}, {DURATION_MAX:g}] s")


def _course(drawing: DrawingBody, p: Array, dt: float) -> Course:
    """Whether rows p (n, 2) [m] repeat or step: a closed drawing does repeat; given times are looked at."""
    if drawing.closed:
        return course(p, dt, from_rest=False, start=0, frequency=1.0 / ((len(p) - 1) * dt))
    return course(p, dt, from_rest=False, start=0) if isinstance(drawing.timing, Given) else Course(0)
