"""The second plant: a Cosserat rod whose chambers stiffen it, and whose air pairs lag and stick.

It stands in for the hardware as the twin does, behind the same valves, camera and faults, but on other mathematics than
the controller's model: a controller and an observer that only ever met their own chain meet here what they lack.
"""

from controller.arrays import Array, Record, Seed, Words
from controller.kernels.compiled import inlined, kernel
from controller.kernels.group import Group
from controller.kernels.model.friction import Sheet, rub
from controller.kernels.plant.camera import NO_SAMPLE, Camera, deliver, expose, open_slot
from controller.kernels.plant.cosserat_rod import CosseratRod, Newton, RodForces, RodMotion, rod_step
from controller.kernels.plant.faults import Faults
from controller.kernels.plant.valve import Chambers, dump, fill_chambers
from controller.kernels.safety.safety import E_STOP

STICKING = 0.5
"""Share of a pair's torque that comes through the slider of its hysteresis: of a small reversal the other half is felt
at once."""


class Pairs(Group):
    """The two chamber pairs, from their pressures to the moments they exert."""

    share: Array
    """Of the cell about each bend the part along which each pair acts (n,2) [1]."""
    along: Array
    """Of each element the same part (n,2) [1]."""
    full: Array
    """Sum of the pressures of a pair, as of its first chamber's, at which it stiffens the rod by `stiffening` and
    stretches it by `stretching` (2,) [Pa]."""
    stiffening: Array
    """Bending stiffness that full pressure of each adds, as a share (2,) [1]."""
    stretching: Array
    """Length that full pressure of each adds, as a share (2,) [1]."""
    slack: Array
    """Difference of the pressures over which a pair's slider sticks, half of it to either side (2,) [Pa]."""
    keep: Array
    """Share of the distance to its torque that a pair's lag leaves after a tick (2,)."""
    difference: Array
    """Of the pressures at the last tick (2,) [Pa]."""
    stretched: Array
    """What the slider holds back, -slack..slack (2,) [Pa]."""
    torque: Array
    """(2,) [N m]."""


class Cosserat(Group):
    """The plant and its memory; built by `build_cosserat`."""

    rod: CosseratRod
    motion: RodMotion
    forces: RodForces
    newton: Newton
    pairs: Pairs
    dt: float
    """Period of the loop [s]."""
    sheet: Sheet
    chambers: Chambers
    camera: Camera
    faults: Faults
    every: Words
    """Elements between two markers, and between two of the telemetry's backbone points (2,)."""
    ticks: Words
    """(1,) steps made."""
    seed: Seed
    """(1,) state of the noise."""


@kernel
def cosserat_step(t_ns: int, plant: Cosserat, telemetry: Record, out_measurement: Record) -> None:
    """Show the plant as it is at t_ns [ns], then advance it by dt under telemetry.pressure_cmd; E_STOP dumps the air.

    As `twin_step`. Not in the paper, whose plant is the hardware ("Experimental Platform"). In place: plant,
    telemetry.twin_backbone.
    """
    tick, chambers, motion = plant.ticks[0], plant.chambers, plant.motion
    telemetry.twin_backbone[0, 0] = telemetry.twin_backbone[0, 1] = 0.0
    free_ends(motion.q, plant.every[1], telemetry.twin_backbone[1:])
    slot = open_slot(t_ns, tick, plant.faults, plant.camera)
    if slot != NO_SAMPLE:
        free_ends(motion.q, plant.every[0], plant.camera.points[slot])
        expose(slot, plant.faults, plant.camera, plant.seed)
    deliver(plant.camera, tick, out_measurement)
    if telemetry.mode == E_STOP:
        dump(plant.dt, chambers)
    fill_chambers(tick, telemetry.pressure_cmd, plant.dt, chambers)
    drive(chambers, plant.pairs)
    stiffen(plant.rod, chambers, plant.pairs, plant.forces)
    rub(plant.rod.m, motion.v, plant.dt, plant.sheet, plant.forces.F)
    rod_step(plant.rod, plant.forces, plant.dt, motion, plant.newton)
    for j in range(4):
        out_measurement.pressures[j] = chambers.sensed[j]
    plant.ticks[0] += 1


@inlined
def free_ends(q: Array, every: int, out_points: Array) -> None:
    """Free ends (n,2) [m] of each `every`-th element in the pose q (3,m). Not in the paper: the grid's own points."""
    for i in range(out_points.shape[0]):
        out_points[i, 0] = q[0, (i + 1) * every - 1]
        out_points[i, 1] = q[1, (i + 1) * every - 1]


@kernel
def drive(chambers: Chambers, pairs: Pairs) -> None:
    """Torques of the pairs after a tick: their pressures' difference through a slider, then a first-order lag.

    The slider follows only beyond its slack (play, Prandtl and Ishlinskii): the torque runs around a loop whose width
    no rate has a part in. Not in the paper: flaws of the plant. In place: pairs.
    """
    p, per = chambers.pressure, chambers.torque_per_pascal
    for j in range(2):
        difference = p[2 * j] - p[2 * j + 1] * (per[2 * j + 1] / per[2 * j])
        held = pairs.stretched[j] + difference - pairs.difference[j]
        pairs.stretched[j] = min(pairs.slack[j], max(-pairs.slack[j], held))
        pairs.difference[j] = difference
        torque = per[2 * j] * (difference - STICKING * pairs.stretched[j])
        pairs.torque[j] = torque + (pairs.torque[j] - torque) * pairs.keep[j]


@kernel
def stiffen(rod: CosseratRod, chambers: Chambers, pairs: Pairs, out_forces: RodForces) -> None:
    """Moments of the pairs in the bends, the bends' stiffness and the elements' lengths under pressure.

    Not in the paper, where no pressure changes them: a flaw of the plant.
    """
    p, per = chambers.pressure, chambers.torque_per_pascal
    level_1 = (p[0] + p[1] * (per[1] / per[0])) / pairs.full[0]
    level_2 = (p[2] + p[3] * (per[3] / per[2])) / pairs.full[1]
    stiffer_1, stiffer_2 = pairs.stiffening[0] * level_1, pairs.stiffening[1] * level_2
    longer_1, longer_2 = pairs.stretching[0] * level_1, pairs.stretching[1] * level_2
    for i in range(rod.k.size):
        first, second = pairs.share[i, 0], pairs.share[i, 1]
        out_forces.k[i] = rod.k[i] * (1.0 + first * stiffer_1 + second * stiffer_2)
        out_forces.moment[i] = first * pairs.torque[0] + second * pairs.torque[1]
        out_forces.longer[i] = pairs.along[i, 0] * longer_1 + pairs.along[i, 1] * longer_2
