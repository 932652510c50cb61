"""Motion capture of any plant's markers: 100 Hz, noisy, late; samples wait here until they are due."""

from controller.arrays import Array, Record, Seed, Words
from controller.kernels.compiled import kernel
from controller.kernels.group import Group
from controller.kernels.plant.faults import LOST, Faults, sample_lost, spoil
from controller.kernels.plant.noise import normal_pair
from controller.schema.modes import Freeze

FREEZE_OFF, FRESH_TIME = int(Freeze.OFF), int(Freeze.FRESH_TIME)
NO_SAMPLE = -1
"""No sample of the markers is taken in this tick."""


class Camera(Group):
    """Motion capture of the markers; samples wait here until they are due."""

    noise: float
    """Standard deviation of each coordinate [m]."""
    period: int
    """Ticks between samples."""
    latency: int
    """Ticks from capture to delivery."""
    t_ns: Words
    """(n,) time of capture; LOST: this sample is never delivered."""
    points: Array
    """(n,10,2) [m]."""


@kernel
def open_slot(t_ns: int, tick: int, faults: Faults, camera: Camera) -> int:
    """Where in camera.points the plant puts its markers in this tick; NO_SAMPLE if none is due, or all are frozen.

    Paper, "Hardware setup": 100 Hz. In place: camera.
    """
    if tick % camera.period != 0:
        return NO_SAMPLE
    slot = int(tick // camera.period % camera.t_ns.size)
    if faults.freeze[0] != FREEZE_OFF:
        repeat(slot, t_ns if faults.freeze[0] == FRESH_TIME else LOST, camera)
        return NO_SAMPLE
    camera.t_ns[slot] = t_ns
    return slot


@kernel
def expose(slot: int, faults: Faults, camera: Camera, seed: Seed) -> None:
    """Make a sample of the markers that lie true in `slot`: noise, losses, faults.

    Not in the paper, which gives no noise. In place: faults.seed, camera, seed.
    """
    points = camera.points[slot]
    for i in range(points.shape[0]):
        x, y = normal_pair(seed)
        points[i, 0] += camera.noise * x
        points[i, 1] += camera.noise * y
    if sample_lost(faults):
        camera.t_ns[slot] = LOST
    spoil(faults, points)


@kernel
def repeat(slot: int, t_ns: int, camera: Camera) -> None:
    """Put the sample taken last into `slot` under another time of capture; LOST: it says nothing new.

    Not in the paper: a fault. In place: camera.
    """
    last = (slot - 1) % camera.t_ns.size
    camera.t_ns[slot] = t_ns
    for i in range(camera.points.shape[1]):
        for j in range(2):
            camera.points[slot, i, j] = camera.points[last, i, j]


@kernel
def deliver(camera: Camera, tick: int, out_measurement: Record) -> None:
    """Hand over the sample whose latency has passed in this tick. Not in the paper, which gives no latency."""
    taken = tick - camera.latency
    if taken < 0 or taken % camera.period != 0:
        return
    slot = taken // camera.period % camera.t_ns.size
    if camera.t_ns[slot] == LOST:
        return
    out_measurement.t_ns = camera.t_ns[slot]
    for i in range(camera.points.shape[1]):
        for j in range(2):
            out_measurement.markers[i, j] = camera.points[slot, i, j]
