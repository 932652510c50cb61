"""Free decays of a body that we know: a finer model than any that is fitted, seen in space with noise."""

import numpy as np

from controller.arrays import Array
from controller.assembly.equilibrium import body_of, carrying, settle
from controller.kernels.model.implicit import make_implicit_work
from controller.kernels.model.rod import make_load
from controller.kernels.model.statics import at_rest, pose
from controller.kernels.observer.observer import Replay
from controller.kernels.observer.replay import RecordedSamples, replay
from controller.research.identification.motion.decays import Decay
from controller.research.identification.offline import in_plane, offline_observer
from controller.schema.actuator import PRESETS, Actuator, Tracking

ARCS = (0.11, 0.21, 0.32)
FINE = 40
SUBSTEPS = 4


def hanging_body(arcs: tuple[float, ...] = ARCS) -> Actuator:
    """Tapered to 0.4 of its base's stiffness, with 150 g at its end; first mode about 2.6 Hz."""
    k = np.array([16.0, 6.4])
    tracking = Tracking(base=(0.1, 0.0, 0.1), axis=(0.0, -1.0, 0.0), arcs=arcs, K_o=(0.0, 3e3), B_o=(0.0, 50.0))
    update = {
        "name": "known", "mass": 0.075, "tip_load": 0.15, "length": arcs[-1], "gravity": (9.81, 0.0), "alpha": 1.0,
        "k": tuple(k.tolist()), "b": tuple((0.006 * k).tolist()), "tracking": tracking,
    }  # fmt: skip
    return PRESETS["P1"].model_copy(update=update)


def decays_of(actuator: Actuator, torques: Array, seed: int = 1, samples: int = 250) -> list[Decay]:
    """One decay for each row of `torques` (d,bodies) [N m], which act from the clamp to the bodies until 50 ms.

    Every coordinate has 0.2 mm of noise; each decay has a plane of its own through the vertical.
    """
    random = np.random.default_rng(seed)
    return [_decay(actuator, 2 * i, u, random.normal(0, 2e-4, (samples, u.size, 3))) for i, u in enumerate(torques)]


def _decay(actuator: Actuator, number: int, u: Array, noise: Array) -> Decay:
    angle = 0.9 * number
    across = np.array([np.cos(angle), 0.0, np.sin(angle)])
    points = _swing(in_plane(actuator, across), u, len(noise))
    base = np.array([0.1, 0.0, 0.1])
    seen = base + points[..., :1] * np.array([0.0, -1.0, 0.0]) + points[..., 1:] * across
    return Decay(number, 0.01 * np.arange(len(noise)), seen + noise)


def _swing(actuator: Actuator, u: Array, samples: int) -> Array:
    """Bodies in the plane (n,bodies,2) [m] after release, without any observer."""
    fine = offline_observer(actuator, [u.size - 1], FINE)
    model, held = fine.model, fine.T @ u
    state = at_rest(model)
    pose(model, settle(carrying(body_of(model), held), model.rest), state.q)
    run = Replay(
        model, state, make_load(FINE, u.size), make_implicit_work(FINE, u.size), fine.sensors, held,
        np.array([0.05, 0.03]), 1e-3 / SUBSTEPS,
    )  # fmt: skip
    nothing = np.zeros((samples, u.size, 2))
    ticks = np.full(samples, 10 * SUBSTEPS, np.int64)
    out = np.empty_like(nothing)
    replay(0, RecordedSamples(nothing, nothing, ticks, 0.0), run, out)
    return out
