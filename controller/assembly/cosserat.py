"""The Cosserat plant, from parameters to arrays."""

import math

import numpy as np

from controller.arrays import Array
from controller.assembly.plant_parts import bent, camera, chambers, damping_ratio, faults
from controller.assembly.rod import (
    NO_STIFFNESS,
    bend_edges,
    chamber_ends,
    computable,
    covered,
    profile,
    rest_bend,
    spread,
)
from controller.errors import ParameterError
from controller.kernels.model.friction import Sheet
from controller.kernels.plant.cosserat import STICKING, Cosserat, Pairs
from controller.kernels.plant.cosserat_rod import (
    CosseratRod,
    RodForces,
    RodMotion,
    make_newton,
    rod_step,
)
from controller.schema.actuator import Actuator
from controller.schema.parameters import BACKBONE_POINTS, SENSORS, RigParameters, TwinParameters
from controller.schema.rigidity import joint_stiffness

SETTLING = 5000
"""Most steps from straight to rest."""
PACE = 0.15
"""Such a step over the time of the rod's swing, or of a fall by its length."""
TINY = 1e-9
"""Gravity below which nothing falls [m/s^2]."""
SETTLED = 1e-11
"""Way of a step from which on the rod rests [rad, lengths]."""
ROUNDS = 20
"""Of the inverse iteration: the second mode is some 40 times as stiff."""
SMALL = 1e-3
"""Largest acceleration of its loads [m/s^2]."""
STATIC_STEP_S = 1e9
"""A step so long that no inertia is left in its equations [s]."""


def build_cosserat(parameters: RigParameters) -> Cosserat:
    """The Cosserat plant of `parameters`, at rest.

    Raises ParameterError where it has no rest, or where numbers run over.
    """
    with computable(parameters.actuator):
        return _built(parameters)


def _built(parameters: RigParameters) -> Cosserat:
    twin, actuator, dt = parameters.twin, parameters.actuator, parameters.controller.dt
    own, n = twin.cosserat, twin.cosserat.elements
    pneumatics = chambers(parameters, own.torque_gain, own.chamber_imbalance)
    rod = cosserat_rod(actuator, twin)
    rest = rest_of(rod)
    return Cosserat(
        rod=damped(rod, rest, twin, damping_ratio(actuator, twin)),
        motion=RodMotion(rest, np.zeros((3, n)), np.zeros((3, n))),
        forces=still(rod),
        newton=make_newton(n),
        pairs=pairs(parameters),
        dt=dt,
        sheet=Sheet(twin.friction, twin.slip, np.zeros((2, n))),
        chambers=pneumatics,
        camera=camera(twin, dt),
        faults=faults(twin, pneumatics),
        every=np.array([n // SENSORS, n // (BACKBONE_POINTS - 1)]),
        ticks=np.zeros(1, np.int64),
        seed=np.array([twin.seed], np.uint64),
    )


def cosserat_rod(actuator: Actuator, twin: TwinParameters) -> CosseratRod:
    """The undamped rod of `actuator`: stiffness and gravity times kappa, as the twin's, so that its statics stay.

    A bend has the compliance of the backbone between the middles of its elements, as the table's joints give it, each
    for its own cell of the table. The rod thus begins at the clamp, and not half a cell of the table before it.
    """
    n, length = twin.cosserat.elements, actuator.length
    edges = np.append((np.arange(n) + 0.5) / n, 1.0)
    cells = profile(actuator.mass_profile, actuator.table_rods)
    m = actuator.mass * np.diff(spread(cells, edges)) / float(spread(cells, np.ones(1))[0])
    m[-1] += actuator.tip_load
    k = twin.kappa * twin.stiffness_scale * bend_stiffness(actuator, n)
    EI = (length - length / (2 * n)) / float(np.sum(1.0 / k))
    EA, GA = twin.cosserat.stretch * EI / length**2, twin.cosserat.shear * EI / length**2
    return CosseratRod(
        l=length / n,
        m=m,
        I=np.full(n, actuator.mass / n * EI / EA),
        EA=EA,
        GA=GA,
        k=k,
        bend=rest_bend(bent(actuator, twin.cosserat.set_curvature), n),
        alpha=0.0,
        beta=0.0,
        g=twin.kappa * np.array(actuator.gravity),
    )


def bend_stiffness(actuator: Actuator, n: int) -> Array:
    """Stiffness (n,) [N m/rad] of the bends of n elements."""
    if actuator.EI is not None:
        return joint_stiffness(actuator.EI, actuator.EI_arc, actuator.length, n)
    table = actuator.table_rods
    compliance = 1.0 / np.maximum(profile(actuator.k, table), NO_STIFFNESS)
    return np.asarray(1.0 / (table * np.diff(spread(compliance, bend_edges(n)))))


def still(rod: CosseratRod) -> RodForces:
    """Of a rod that nothing but gravity acts on."""
    n = rod.m.size
    return RodForces(rod.k.copy(), np.zeros(n), np.zeros((2, n)), np.zeros(n))


def rest_of(rod: CosseratRod, forces: RodForces | None = None) -> Array:
    """The pose (3,n) in which the rod rests: where it creeps to from straight, in steps in which it does not turn far.

    Under `forces`, or under gravity alone. Raises ParameterError where it does not come to rest.
    """
    n, length = rod.m.size, rod.l * rod.m.size
    swing = length * math.sqrt(rod.m.sum() * float(np.sum(1.0 / rod.k)))
    fall = math.sqrt(length / max(float(np.hypot(*rod.g)), TINY))
    h = PACE * min(swing, fall)
    creeping = rod._replace(alpha=0.0, beta=h / 2)  # all stress is that at the end of a step: Euler backward
    loads = forces or still(rod)
    pose = np.stack([rod.l * np.cumsum(1.0 + loads.longer), np.zeros(n), np.zeros(n)])
    motion, newton = RodMotion(pose, np.zeros((3, n)), np.zeros((3, n))), make_newton(n)
    for _ in range(SETTLING):
        motion.v[:] = motion.way[:] = 0.0
        rod_step(creeping, loads, h, motion, newton)
        if np.abs(motion.way / [[length], [length], [1.0]]).max() < SETTLED:
            return pose
    raise ParameterError("gravity, mass and k: the Cosserat plant comes to no rest")


def first_frequency(rod: CosseratRod, rest: Array) -> float:
    """Of the small motions about `rest` (3,n) [rad/s], by inverse iteration: a step without inertia solves the statics.

    Stresses count there as the mean of both ends', so such a step goes twice as far as the load's static deflection.
    """
    n, newton = rod.m.size, make_newton(rod.m.size)
    M = np.stack([rod.m, rod.m, rod.I])
    shape, square = np.zeros((3, n)), 0.0
    shape[1] = np.linspace(0.0, 1.0, n) ** 2
    for _ in range(ROUNDS):
        load = M * shape * (SMALL / np.abs(shape[1]).max())
        forces = still(rod)._replace(F=load[:2].copy(), moment=np.cumsum(load[2, ::-1])[::-1].copy())
        motion = RodMotion(rest.copy(), np.zeros((3, n)), np.zeros((3, n)))
        rod_step(rod, forces, STATIC_STEP_S, motion, newton)
        shape = motion.way / 2.0
        square = float(np.sum(load * shape) / np.sum(M * shape**2))
    return math.sqrt(square)


def damped(rod: CosseratRod, rest: Array, twin: TwinParameters, zeta: float) -> CosseratRod:
    """The rod with the damping ratio zeta in its first mode at `rest`, partly by stiffness and partly by mass."""
    omega = first_frequency(rod, rest)
    share = twin.cosserat.viscosity
    return rod._replace(alpha=2.0 * zeta * (1.0 - share) * omega, beta=2.0 * zeta * share / omega)


def pairs(parameters: RigParameters) -> Pairs:
    """The chamber pairs, empty; each reaches from the end of one rod of the table to that of another."""
    actuator, own, dt = parameters.actuator, parameters.twin.cosserat, parameters.controller.dt
    full, ends = actuator.u_max * actuator.chamber_slopes[::2], chamber_ends(actuator)
    shares = np.array([actuator.stiffening, actuator.stretching])
    stiffening, stretching = shares * actuator.u_max * actuator.pair_slopes
    return Pairs(
        share=np.column_stack([covered(bend_edges(own.elements), *pair) for pair in ends]),
        along=np.column_stack([covered(np.linspace(0.0, 1.0, own.elements + 1), *pair) for pair in ends]),
        full=full,
        stiffening=stiffening if stiffening.any() else np.full(2, own.stiffening),
        stretching=stretching,
        slack=np.array(own.pair_hysteresis) * full / STICKING,
        keep=np.array([math.exp(-dt / lag) if lag > 0.0 else 0.0 for lag in own.lag]),
        difference=np.zeros(2),
        stretched=np.zeros(2),
        torque=np.zeros(2),
    )
