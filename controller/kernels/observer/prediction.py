"""Where a marker is between its samples: where the model goes by itself, and how far off that the marker was seen.

A model that the torques alone move, without any spring, tells most of how a marker goes on. What it does not tell, the
marker's distance from it, is small and slow, and a filter follows it (alpha_beta.py). Each sample enters at its time of
capture: the model's points of the last moments are kept. A second filter follows the marker without any model, and the
better the one foretells samples than the other, the more it counts. Nothing here depends on what the springs then do,
so neither noise nor a late sample can make the observer swing: it is a chain that is pulled to a path.

The noise comes from the samples themselves: third differences of the distances, in which no motion of an arm is left.
Not in the paper, which holds a sample until the next.
"""

import math

from controller.arrays import Array, Words
from controller.kernels.compiled import kernel
from controller.kernels.group import Group
from controller.kernels.memory import Sensing
from controller.kernels.model.implicit import ImplicitWork, implicit_step
from controller.kernels.model.rod import Load, RodModel, RodState
from controller.kernels.model.statics import Places, points_on
from controller.kernels.observer.alpha_beta import AlphaBeta, begin_point, correct_point

THIRD = 20.0
"""Variance of third differences over that of the samples, 1 + 9 + 9 + 1."""
NOISE_SHARE = 0.01
"""Of a new third difference in the variance of the noise."""
OUTLIER = 9.0
"""A third difference beyond three standard deviations counts as three: no jump of a marker is its noise."""
NOISE_VARIANCE = (1e-5**2, 1e-4**2)
"""Least variance of a marker's noise, and that before the first samples [m^2]."""
FORGET_AFTER = 0.2
"""A marker that was out of sight for longer begins again where it is seen [s]."""


class Prediction(Group):
    """The model that the torques alone move, and where the markers were seen, off it and by themselves."""

    model: RodModel
    """The observer's, with the actuator's own damping; they share their stiffness and lengths."""
    state: RodState
    load: Load
    """The torques on it; no springs."""
    trail: Array
    """Ring of its position at the sensors at the ends of the last ticks (ticks,10,2) [m]."""
    newest: Words
    """(1,) place of the last in the ring."""
    off: AlphaBeta
    """The markers' distances from the model."""
    alone: AlphaBeta
    """The markers."""
    taken_ns: Words
    """(10,) when each was captured last; 0 before the first sample."""
    sample_ns: Words
    """(1,) capture of the newest sample that was taken over."""
    before: Array
    """The last three distances as measured, the newest first (3,10,2) [m]; nan before a marker's first samples."""
    noise: Array
    """Variance of a marker's noise, of a coordinate (10,) [m^2]."""
    p: Array
    """Where each marker is held to be in the middle of the step (10,2) [m]."""
    v: Array
    """Its velocity there (10,2) [m/s]."""


@kernel
def predict(dt: float, torque: Array, sensors: Places, work: ImplicitWork, prediction: Prediction) -> None:
    """Advance the model by dt [s] under the torques `torque` (N,) on its rods alone.

    The constrained model: paper, "Dynamic observer". In place: work, prediction.
    """
    newest = (prediction.newest[0] + 1) % prediction.trail.shape[0]
    prediction.newest[0] = newest
    for i in range(torque.size):
        prediction.load.Q_theta[i] = torque[i]
    implicit_step(prediction.model, prediction.load, dt, prediction.state, work)
    points_on(prediction.state.q, sensors, prediction.trail[newest])


@kernel
def learn(t_ns: int, dt: float, sensing: Sensing, prediction: Prediction) -> None:
    """Take over the sample in `sensing` if it is a new one; the last step, of dt [s], has ended at t_ns.

    A sample that is older than the trail tells nothing. Not in the paper: see the module. In place: prediction.
    """
    late = (t_ns - sensing.sample_ns[0]) * 1e-9 / dt
    ticks, length = int(late), prediction.trail.shape[0]
    if sensing.sample_ns[0] == prediction.sample_ns[0] or late < 0.0 or ticks + 1 >= length:
        return
    prediction.sample_ns[0] = sensing.sample_ns[0]
    after = (prediction.newest[0] - ticks) % length
    before, share = (after - 1) % length, late - ticks
    for j in range(prediction.p.shape[0]):
        x, y = sensing.p[j, 0], sensing.p[j, 1]
        if math.isfinite(x + y):
            one, other = prediction.trail[after, j], prediction.trail[before, j]
            off_x = x - one[0] - share * (other[0] - one[0])
            off_y = y - one[1] - share * (other[1] - one[1])
            take_point(j, (x, y), (off_x, off_y), sensing, prediction)


@kernel
def take_point(
    j: int, p: tuple[float, float], off: tuple[float, float], sensing: Sensing, prediction: Prediction
) -> None:
    """Marker j was seen at p, `off` from the model [m]. Not in the paper: see the module. In place: prediction."""
    apart = (sensing.sample_ns[0] - prediction.taken_ns[j]) * 1e-9 + sensing.late[0]
    if prediction.taken_ns[j] == 0 or apart > FORGET_AFTER:
        for axis in range(2):
            for k in range(prediction.before.shape[0]):
                prediction.before[k, j, axis] = math.nan
        begin_point(j, off[0], off[1], prediction.noise[j], prediction.off)
        begin_point(j, p[0], p[1], prediction.noise[j], prediction.alone)
    else:
        together, noise = sensing.held[0] > 0.0, prediction.noise[j]
        correct_point(j, off[0], off[1], apart, together, noise, prediction.off)
        correct_point(j, p[0], p[1], apart, together, noise, prediction.alone)
    note_noise(j, off, prediction)
    prediction.taken_ns[j] = sensing.sample_ns[0]


@kernel
def note_noise(j: int, off: tuple[float, float], prediction: Prediction) -> None:
    """Learn from the third difference of the distances of marker j how large its noise is.

    Not in the paper: see the module. In place: prediction.before, prediction.noise.
    """
    last = prediction.before
    for axis in range(2):
        third = off[axis] - 3.0 * last[0, j, axis] + 3.0 * last[1, j, axis] - last[2, j, axis]
        if math.isfinite(third):
            seen = min(third * third / THIRD, OUTLIER * prediction.noise[j])
            prediction.noise[j] = max(
                prediction.noise[j] + NOISE_SHARE * (seen - prediction.noise[j]), NOISE_VARIANCE[0]
            )
        last[2, j, axis], last[1, j, axis], last[0, j, axis] = last[1, j, axis], last[0, j, axis], off[axis]


@kernel
def foresee(t_ns: int, dt: float, prediction: Prediction) -> None:
    """Where the markers are in the middle of the last step, of dt [s], which has ended at t_ns: p and v.

    Not in the paper: see the module. In place: prediction.p, prediction.v.
    """
    off, alone, newest = prediction.off, prediction.alone, prediction.newest[0]
    last = (newest - 1) % prediction.trail.shape[0]
    for j in range(prediction.p.shape[0]):
        age = (t_ns - prediction.taken_ns[j]) * 1e-9 - 0.5 * dt
        share = share_of_model(off.innovation[j], alone.innovation[j])
        for axis in range(2):
            p, v = alone.x[j, axis] + age * alone.rate[j, axis], alone.rate[j, axis]
            before, after = prediction.trail[last, j, axis], prediction.trail[newest, j, axis]
            by_model = 0.5 * (before + after) + off.x[j, axis] + age * off.rate[j, axis]
            prediction.p[j, axis] = p + share * (by_model - p)
            prediction.v[j, axis] = v + share * ((after - before) / dt + off.rate[j, axis] - v)


@kernel
def share_of_model(by_model: float, alone: float) -> float:
    """What counts of the model's word, by the variances of both innovations [m^2]. Not in the paper: see the module."""
    return alone * alone / (alone * alone + by_model * by_model)


@kernel
def reset_prediction(state: RodState, sensors: Places, prediction: Prediction) -> None:
    """Begin again from the pose of `state`, at rest there; what was learnt of the noise stays.

    Initial conditions: paper, "Dynamic observer". In place: prediction.
    """
    for row in range(3):
        for i in range(state.q.shape[1]):
            prediction.state.q[row, i], prediction.state.v[row, i] = state.q[row, i], 0.0
    for tick in range(prediction.trail.shape[0]):
        points_on(state.q, sensors, prediction.trail[tick])
    for j in range(prediction.taken_ns.size):
        prediction.taken_ns[j] = 0
