"""Cosserat rods of the tests, and their motion and energy."""

from typing import Any

import numpy as np

from controller.arrays import Array
from controller.assembly.cosserat import cosserat_rod, still
from controller.kernels.plant.cosserat_rod import CosseratRod, RodForces, RodMotion, make_newton, rod_step
from controller.schema.actuator import PRESETS, Actuator
from controller.schema.parameters import CosseratParameters, TwinParameters

EI, LENGTH = 1.9e-3, 0.253


def even(actuator: Actuator = PRESETS["P1"], **changes: Any) -> Actuator:
    """`actuator` with the same bending stiffness from clamp to tip, as a formula has it."""
    return Actuator.model_validate(
        actuator.model_dump(exclude={"k", "b"}) | {"EI": (EI,), "EI_arc": (), "beta": 0.0} | changes
    )


def rod_of(actuator: Actuator, **own: Any) -> CosseratRod:
    """Its rod, undamped and with the stiffness of its file."""
    return cosserat_rod(actuator, TwinParameters(kappa=1.0, cosserat=CosseratParameters(**own)))


def straight(rod: CosseratRod) -> RodMotion:
    """At rest along +x."""
    n = rod.m.size
    pose = np.stack([rod.l * np.arange(1, n + 1), np.zeros(n), np.zeros(n)])
    return RodMotion(pose, np.zeros((3, n)), np.zeros((3, n)))


def struck(rod: CosseratRod, speed: float) -> RodMotion:
    """Straight, and moving sideways: the tip at `speed` [m/s], the rest less by the square of its arc."""
    motion, arc = straight(rod), np.arange(1, rod.m.size + 1) / rod.m.size
    motion.v[1] = speed * arc**2
    motion.v[2] = 2.0 * speed * (arc - 0.5 / rod.m.size) / (rod.l * rod.m.size)
    return motion


def tip_course(
    rod: CosseratRod, motion: RodMotion, seconds: float, h: float, forces: RodForces | None = None
) -> tuple[Array, Array]:
    """The tip (n,2) [m] and the energy (n,) [J] after every step of `h`."""
    newton, forces = make_newton(rod.m.size), forces or still(rod)
    tips, energies = np.zeros((round(seconds / h), 2)), np.zeros(round(seconds / h))
    for i in range(len(tips)):
        rod_step(rod, forces, h, motion, newton)
        tips[i], energies[i] = motion.q[:2, -1], energy(rod, motion)
    return tips, energies


def energy(rod: CosseratRod, motion: RodMotion) -> float:
    """Kinetic, strain and gravity's [J], written down again."""
    q, v = motion.q, motion.v
    d = np.diff(q[:2], axis=1, prepend=0.0)
    t, n = np.array([np.cos(q[2]), np.sin(q[2])]), np.array([-np.sin(q[2]), np.cos(q[2])])
    stretch, shear = (t * d).sum(axis=0) / rod.l - 1.0, (n * d).sum(axis=0) / rod.l
    bend = np.diff(q[2], prepend=0.0) - rod.bend
    kinetic = (rod.m * (v[:2] ** 2).sum(axis=0) + rod.I * v[2] ** 2).sum() / 2
    strain = rod.l * (rod.EA * stretch**2 + rod.GA * shear**2).sum() / 2 + (rod.k * bend**2).sum() / 2
    return float(kinetic + strain - (rod.m * (rod.g @ q[:2])).sum())
