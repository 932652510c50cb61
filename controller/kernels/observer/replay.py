"""The observer over recorded data: samples held, virtual forces at the sensed bodies, a held pose released."""

from typing import NamedTuple

from controller.arrays import Array, Words
from controller.kernels.compiled import inlined, kernel
from controller.kernels.model.implicit import implicit_step
from controller.kernels.model.statics import points_on
from controller.kernels.observer.observer import HeldSample, Replay, attach


class RecordedSamples(NamedTuple):
    """What was recorded, n samples of m bodies in the model's frame."""

    p: Array
    """Positions (n,m,2) [m]."""
    v: Array
    """Velocities by difference from the sample before (n,m,2) [m/s]."""
    ticks: Words
    """For how many steps each sample is held (n,)."""
    age: Array
    """(1,) by how long it is carried on: 0, it is held [s]."""


@kernel
def replay(samples: RecordedSamples, used: int, run: Replay, out_points: Array) -> None:
    """Advance `run` through all samples, pulled to the bodies with a bit in `used`; estimates (n,m,2) [m].

    A held sample is its signal half a hold late, and so is the model that it draws along: the estimate for a sample is
    the model's position in the middle of its hold. Paper, "Dynamic observer"; of recordings it says nothing.
    In place: run.
    """
    tick = 0
    for k in range(samples.ticks.size):
        points_on(run.state.q, run.sensors, out_points[k])  # stays where samples come faster than ticks
        attach(HeldSample(samples.p[k], samples.v[k], samples.age), used, run)
        for step in range(samples.ticks[k]):
            fade_hold(tick * run.dt, run)
            implicit_step(run.model, run.load, run.dt, run.state, run.work)
            tick += 1
            if step == samples.ticks[k] // 2:
                points_on(run.state.q, run.sensors, out_points[k])


@inlined
def fade_hold(t: float, run: Replay) -> None:
    """Load of the held pose at t [s]: whole before the release, then falling to zero on a line.

    Not in the paper: recorded decays begin from a held pose. In place: run.load.
    """
    share = 1.0
    if t > run.release[0]:
        share = max(0.0, 1.0 - (t - run.release[0]) / run.release[1])
    for i in range(run.held.size):
        run.load.Q_theta[i] = share * run.held[i]
