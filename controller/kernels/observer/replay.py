"""The observer over recorded data: samples carried on, virtual forces at the sensed bodies, a held pose released."""

from controller.arrays import Array, Words
from controller.kernels.compiled import inlined, kernel
from controller.kernels.group import Group
from controller.kernels.model.implicit import implicit_step
from controller.kernels.model.statics import points_on
from controller.kernels.observer.observer import Replay, attach


class RecordedSamples(Group):
    """What was recorded, n samples of m bodies in the model's frame."""

    p: Array
    """Positions (n,m,2) [m]."""
    v: Array
    """Velocities by difference from the sample before (n,m,2) [m/s]."""
    ticks: Words
    """Steps from each sample to the next (n,)."""
    old: float
    """Age from which on a sample pulls no more [s]."""


@kernel
def replay(used: int, samples: RecordedSamples, run: Replay, out_points: Array) -> None:
    """Advance `run` through all samples, pulled to the bodies with a bit in `used`; estimates (n,m,2) [m].

    As `sense` and `observe` do it live, a sample is carried on with its last velocity to the middle of each step.
    The estimate is the model at the very time of the sample, before the sample has pulled: samples up to the one before
    made it. Paper, "Dynamic observer"; of recordings it says nothing. In place: run.
    """
    tick = 0
    for k in range(samples.ticks.size):
        points_on(run.state.q, run.sensors, out_points[k])
        for step in range(samples.ticks[k]):
            age = step * run.dt
            attach(samples.p[k], samples.v[k], age + 0.5 * run.dt, used if age <= samples.old else 0, run)
            fade_hold(tick * run.dt, run)
            implicit_step(run.model, run.load, run.dt, run.state, run.work)
            tick += 1


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
