"""The same rod in PyElastica, a Cosserat rod engine that we did not write (the extra `engines`).

Its elements and hinges are ours, with one clamped element before the base so that its first inner node is hinge 0. It
also stretches and shears, and its mass sits in the nodes: the tips agree at rest, and in motion to a few millimetres.
"""

import importlib
import math
import time
from typing import Any, TypedDict

import numpy as np

from controller.assembly.rod import build_rod
from controller.kernels.model.rod import RodModel, make_load, make_work
from controller.kernels.model.statics import at_rest, tip_of
from controller.research.bench.scaling import run_steps
from controller.schema.actuator import PRESETS
from controller.schema.parameters import DT

RODS, TORQUE, SECONDS = 10, 0.02, 2.0
"""Step of torque on the last rod [N m], and the time simulated after it [s]."""
ELASTICA_DT = 2e-4
"""Steps [s]. PyElastica's is explicit; with this radius it diverges at 5e-4 s."""
RADIUS = 0.005
"""Radius of PyElastica's rod [m]; bending stiffness and mass do not depend on it, shear and stretch do."""


class ElasticaFigures(TypedDict):
    """Both engines on the same rod."""

    elastica_over_ours: float
    """Processor time per simulated second, theirs over ours."""
    ours_seconds_per_second: float
    """Processor time per simulated second [s]."""
    elastica_seconds_per_second: float
    tip_difference_m: float
    """Largest distance between the tips in motion [m]."""
    tip_difference_at_rest_m: float
    """Distance at the end, when the motion has all but died [m]."""


def beside_elastica() -> ElasticaFigures | None:
    """Time and tips of both after a step of torque, undamped hinges, mass damping; None without PyElastica."""
    try:
        elastica: Any = importlib.import_module("elastica")
    except ImportError:
        return None
    model = build_rod(PRESETS["P1"], RODS)._replace(b=np.zeros(RODS))
    ours, our_tips = run_ours(model)
    theirs, their_tips = run_elastica(elastica, model)
    apart = np.linalg.norm(our_tips - their_tips, axis=1)
    return ElasticaFigures(
        elastica_over_ours=theirs / ours,
        ours_seconds_per_second=ours,
        elastica_seconds_per_second=theirs,
        tip_difference_m=float(apart.max()),
        tip_difference_at_rest_m=float(apart[-1]),
    )


def run_ours(model: RodModel) -> tuple[float, np.ndarray]:
    """Processor time per simulated second [s], and the tip after every DT (n,2) [m]."""
    state, load, work = at_rest(model), make_load(RODS), make_work(RODS)
    load.Q_theta[-1] = TORQUE
    tips = np.zeros((round(SECONDS / DT), 2))
    for i in range(len(tips)):
        run_steps(model, state, load, DT, work, 1)
        tips[i] = tip_of(model, state.q)
    start = time.thread_time()
    run_steps(model, state, load, DT, work, len(tips))
    return (time.thread_time() - start) / SECONDS, tips


def run_elastica(elastica: Any, model: RodModel) -> tuple[float, np.ndarray]:
    """The same of PyElastica, without its compilation."""
    simulator, rod = build_elastica(elastica, model)
    stepper, now = elastica.PositionVerlet(), np.float64(0.0)
    stepper.step(build_elastica(elastica, model)[0], now, ELASTICA_DT)
    tips = np.zeros((round(SECONDS / DT), 2))
    start = time.thread_time()
    for i in range(len(tips)):
        for _ in range(round(DT / ELASTICA_DT)):
            now = stepper.step(simulator, now, ELASTICA_DT)
        tips[i] = rod.position_collection[:2, -1]
    return (time.thread_time() - start) / SECONDS, tips


def build_elastica(elastica: Any, model: RodModel) -> tuple[Any, Any]:
    """A simulator with the rod of `model`, clamped, damped, with the torque on its last element; and the rod."""
    parts = (elastica.BaseSystemCollection, elastica.Constraints, elastica.Forcing, elastica.Damping)
    simulator: Any = type("Simulator", parts, {})()
    length, area, second_moment = float(model.L[0]), math.pi * RADIUS**2, math.pi * RADIUS**4 / 4
    rod = elastica.CosseratRod.straight_rod(
        n_elements=RODS + 1,
        start=np.array([-length, 0.0, 0.0]),
        direction=np.array([1.0, 0.0, 0.0]),
        normal=np.array([0.0, 0.0, 1.0]),
        base_length=length * (RODS + 1),
        base_radius=RADIUS,
        density=float(model.m[0]) / (length * area),
        youngs_modulus=float(model.k[0]) * length / second_moment,
    )
    simulator.append(rod)
    clamp = {"constrained_position_idx": (0,), "constrained_director_idx": (0,)}
    simulator.constrain(rod).using(elastica.OneEndFixedBC, **clamp)
    simulator.add_forcing_to(rod).using(type("Turn", (elastica.NoForces,), {"apply_torques": turn_last}))
    damping = {"uniform_damping_constant": model.alpha, "time_step": ELASTICA_DT}
    simulator.dampen(rod).using(elastica.AnalyticalLinearDamper, **damping)
    simulator.finalize()
    return simulator, rod


def turn_last(_: Any, system: Any, time: float = 0.0) -> None:
    """TORQUE about z on the last element of the rod `system`, in that element's frame."""
    system.external_torques[:, -1] += TORQUE * system.director_collection[:, 2, -1]
