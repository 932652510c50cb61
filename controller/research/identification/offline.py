"""The observer over recorded motions: the live observer's law and rods, with the model of an actuator file."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from controller.arrays import Array
from controller.assembly.rod import build_rod, profile
from controller.errors import ParameterError
from controller.kernels.model.implicit import make_implicit_work
from controller.kernels.model.rod import RodModel, RodState, make_load
from controller.kernels.model.statics import Places, at_rest, chosen, places, pose
from controller.kernels.observer.observer import Replay
from controller.kernels.observer.replay import RecordedSamples, replay
from controller.research.identification.motion.hold import held_pose, positions, torques_to
from controller.research.identification.plane import PlaneMotion
from controller.schema.actuator import Actuator, Tracking
from controller.schema.parameters import DT, SafetyLimits

OLD = SafetyLimits().measurement_old


class Offline(NamedTuple):
    """What stays the same for all motions."""

    model: RodModel
    sensors: Places
    """The tracked bodies (m)."""
    rest: Array
    """Their places at the model's rest (m,2) [m]."""
    T: Array
    """Torques from the clamp to each body, on the rods (N,m) [1]."""
    tracking: Tracking
    sensed: tuple[int, ...]
    """Sensed bodies, from 0."""


def offline_observer(actuator: Actuator, sensed: Sequence[int], rods: int | None = None) -> Offline:
    """Observer with the model of `actuator`, whose `tracking` says where the bodies sit; `sensed` counts from 0.

    Raises ParameterError when tracking or gains are missing.
    """
    tracking = actuator.tracking
    if tracking is None:
        raise ParameterError(f"actuator {actuator.name} has no table tracking, which says where the tracked bodies sit")
    if not any(tracking.K_o):
        raise ParameterError(f"tracking.K_o = {tracking.K_o} N/m of actuator {actuator.name} pulls at nothing")
    model = build_rod(actuator, rods or actuator.table_rods)
    arcs = np.array(tracking.arcs)
    sensors = places(model, np.minimum(arcs, actuator.length))
    rest = positions(model, model.rest, sensors)
    return Offline(model, sensors, rest, torques_to(model, arcs), tracking, tuple(sensed))


def in_plane(actuator: Actuator, direction: Array) -> Actuator:
    """`actuator` as it bends in the plane of `direction` (dims,), a unit vector in the file's coordinates.

    Bending stiffness is a tensor of the cross-section: k cos^2 + k_across sin^2 of the angle to the principal
    direction. Damping b = beta k goes with it.
    """
    tracking = actuator.tracking
    if tracking is None or tracking.k_across is None:
        return actuator
    along = np.array(tracking.principal) / np.linalg.norm(tracking.principal)
    share = float(np.clip(along @ direction, -1.0, 1.0) ** 2)
    own = np.array(actuator.k)
    k = share * own + (1.0 - share) * np.array(tracking.k_across)
    damped = profile(actuator.b, own.size) if own.size > 1 else np.array(actuator.b[:1])
    flat = tracking.model_copy(update={"principal": (), "k_across": None})
    update = {"k": tuple(k.tolist()), "b": tuple((damped * k / own).tolist()), "tracking": flat}
    return actuator.model_copy(update=update)


def estimate(offline: Offline, motion: PlaneMotion) -> Array:
    """Displacements of all bodies from the model's rest (n,m,2) [m], from those of the sensed bodies alone.

    The model starts in the static pose that the first sample of the sensed bodies suggests, and is let go as the
    actuator file says. Only differences from rest are compared, so a crooked rest does not count as motion.
    """
    pulled = list(offline.sensed)
    p = np.full((len(motion.t), offline.sensors.rod.size, 2), np.nan)
    p[:, pulled] = motion.moved[:, pulled] + offline.rest[pulled]
    state, held = _start(offline, motion.moved[0, pulled])
    rods = offline.model.L.size
    load = make_load(rods, offline.sensors.rod.size)
    load.springs.K[:], load.springs.B[:] = offline.tracking.K_o, offline.tracking.B_o
    run = Replay(
        model=offline.model,
        state=state,
        load=load,
        work=make_implicit_work(rods, offline.sensors.rod.size),
        sensors=offline.sensors,
        held=held,
        release=np.array(offline.tracking.release),
        dt=DT,
    )
    out = np.empty_like(p)
    replay(sum(1 << body for body in pulled), _samples(motion.t, p), run, out)
    return np.asarray(out - offline.rest)


def _start(offline: Offline, moved: Array) -> tuple[RodState, Array]:
    """State before the first sample, at rest in the held pose, and the torques on the rods that hold it."""
    state, scatter = at_rest(offline.model), np.array(offline.tracking.hold)
    if scatter.size == 0:
        return state, np.zeros(offline.model.L.size)
    seen = chosen(offline.sensors, offline.sensed)
    theta, held = held_pose(offline.model, offline.T, seen, moved, scatter)
    pose(offline.model, theta, state.q)
    return state, held


def _samples(t: Array, p: Array) -> RecordedSamples:
    """Samples at t (n,) [s], each carried on until the next one comes."""
    v = np.zeros_like(p)
    v[1:] = np.diff(p, axis=0) / np.diff(t)[:, None, None]
    grid = np.round(t / DT).astype(np.int64)
    return RecordedSamples(p, v, np.diff(grid, append=grid[-1]), OLD)
