"""`tendril bench` without the live loop: every time is a median, and what is compared is timed in turns in one run."""

from typing import TypedDict

import numpy as np

from controller.assembly.rod import build_rod
from controller.kernels.model.rod import Load, RodModel, make_load, make_work
from controller.kernels.model.statics import at_rest, tip_of
from controller.research.bench.elastica_rod import ElasticaFigures, beside_elastica
from controller.research.bench.ensemble_bench import EnsembleFigures, time_ensembles
from controller.research.bench.mujoco_chain import MujocoChain, lacks_mujoco
from controller.research.bench.proof_bench import ProofFigures, time_proofs
from controller.research.bench.scaling import Scaling, run_steps, step_us, time_chains
from controller.research.bench.stopwatch import time_steps
from controller.research.bench.tick_bench import closed_loop
from controller.schema.actuator import PRESETS
from controller.schema.modes import Integrator
from controller.schema.parameters import DT, ControllerParameters, RigParameters
from controller.system.progress import ProgressCallback, no_progress

TORQUE = 0.02
"""Step of torque on the last rod [N m]."""
CHAIN_SECONDS = 2.0
FINE_SECONDS = 3.0
"""Simulated time of the closed loop with 1000 rods [s]."""


class Figures(TypedDict):
    """What `bench` measures; times are medians [us]."""

    rod_step_us: float
    mujoco_step_us: float | None
    """None, as the next two, where MuJoCo is not installed."""
    rk4_over_mujoco: float | None
    mujoco_tip_difference_m: float | None
    tick_us: float
    tick_n1000_us: float
    """The tick with 1000 rods and the implicit step."""
    tick_n1000_over_n10: float
    closed_loop_seconds: float
    """Simulated time of the closed loop with twin, 10 rods, on one core [s]."""
    closed_loop_seconds_per_second: float
    ensemble: EnsembleFigures
    """The closed loop as calibrations run it."""
    implicit_n1000_us: float
    implicit_n1000_over_n10: float
    rk4_n1000_over_n10: float
    scaling: list[Scaling]
    link: ProofFigures
    elastica: ElasticaFigures | None
    """None where PyElastica is not installed."""


def bench(quick: bool = False, told: ProgressCallback = no_progress) -> Figures:
    """All figures but the live loop's; `told` hears how far. Raises TendrilError when a state is not finite."""
    rounds = 31 if quick else 201
    rod, mujoco = time_beside_mujoco(rounds)
    told(0.1)
    loop = closed_loop(RigParameters(), 20.0 if quick else 1000.0)
    told(0.4)
    fine = ControllerParameters(rods=1000, integrator=Integrator.IMPLICIT)
    fine_loop = closed_loop(RigParameters(controller=fine), FINE_SECONDS)
    told(0.5)
    rows = time_chains(rounds)
    told(0.9)
    implicit = step_us(rows, "implicit", 1000)
    return Figures(
        rod_step_us=rod,
        mujoco_step_us=mujoco,
        rk4_over_mujoco=None if mujoco is None else rod / mujoco,
        mujoco_tip_difference_m=None if mujoco is None else mujoco_tip_difference(),
        tick_us=loop.tick_us,
        tick_n1000_us=fine_loop.tick_us,
        tick_n1000_over_n10=fine_loop.tick_us / loop.tick_us,
        closed_loop_seconds=loop.seconds,
        closed_loop_seconds_per_second=loop.seconds_per_second,
        ensemble=time_ensembles(3 if quick else 10),
        implicit_n1000_us=implicit,
        implicit_n1000_over_n10=implicit / step_us(rows, "implicit", 10),
        rk4_n1000_over_n10=step_us(rows, "RK4", 1000) / step_us(rows, "RK4", 10),
        scaling=rows,
        link=time_proofs(rounds),
        elastica=beside_elastica(),
    )


def hinge_chain() -> tuple[RodModel, Load]:
    """P1 with 10 rods, without mass damping (MuJoCo's hinges have none), and the torque on its last rod."""
    model = build_rod(PRESETS["P1"], 10)._replace(alpha=0.0)
    load = make_load(10)
    load.Q_theta[-1] = TORQUE
    return model, load


def mujoco_tip_difference() -> float:
    """Largest distance between our tip and MuJoCo's [m] over 2 s after the step of torque."""
    model, load = hinge_chain()
    state, work, chain = at_rest(model), make_work(10), MujocoChain(model, DT)
    chain.load(load.Q_theta)
    worst = 0.0
    for _ in range(round(CHAIN_SECONDS / DT)):
        run_steps(model, state, load, DT, work, 1)
        chain.step()
        worst = max(worst, float(np.linalg.norm(chain.tip() - tip_of(model, state.q))))
    return worst


def time_beside_mujoco(rounds: int) -> tuple[float, float | None]:
    """Time of one step of ours and of MuJoCo's [us], measured in turns: both see the same disturbances.

    None for MuJoCo's where it is not installed.
    """
    model, load = hinge_chain()
    state, work = at_rest(model), make_work(10)
    chain = None if lacks_mujoco() else MujocoChain(model, DT)
    ours, theirs = [], []
    if chain:
        chain.load(load.Q_theta)
    for _ in range(rounds):
        ours.append(time_steps(lambda count: run_steps(model, state, load, DT, work, count), 1000))
        if chain:
            theirs.append(time_steps(chain.step, 200))
    return float(np.median(ours)), float(np.median(theirs)) if chain else None
