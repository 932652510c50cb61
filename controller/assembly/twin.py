"""The simulated plant, from parameters to arrays."""

import math

import numpy as np

from controller.assembly.equilibrium import ChainStatics, equilibrium
from controller.assembly.plant_parts import bent, camera, chambers, faults
from controller.assembly.rod import build_rod, computable, damped, stiffest
from controller.assembly.stability import backbone_places, sensor_places, stable_substeps
from controller.kernels.model.friction import Hysteresis, Sheet
from controller.kernels.model.implicit import make_implicit_work
from controller.kernels.model.pressed import owning, unpressed
from controller.kernels.model.rod import RodModel, make_load, make_work
from controller.kernels.model.statics import at_rest
from controller.kernels.plant.twin import Creep, Twin
from controller.schema.actuator import Actuator
from controller.schema.modes import Integrator
from controller.schema.parameters import RigParameters, TwinParameters


def build_twin(parameters: RigParameters) -> Twin:
    """The simulated plant of `parameters`, at rest, with the substeps that its fastest mode needs.

    Raises ParameterError where it has no rest, is too fast to be computed in time, or where numbers run over.
    """
    with computable(parameters.actuator):
        return _built(parameters)


def _built(parameters: RigParameters) -> Twin:
    twin, actuator, dt = parameters.twin, parameters.actuator, parameters.controller.dt
    model = twin_model(actuator, twin)
    tightest = model._replace(k=stiffest(model, actuator.u_max) * (1.0 + sum(twin.creep) + twin.hysteresis))
    rods, bends = twin.rods, np.diff(model.rest, prepend=0.0)
    pneumatics, own = chambers(parameters, twin.torque_gain, twin.chamber_imbalance), owning(model)
    markers, backbone = sensor_places(model), backbone_places(model)
    return Twin(
        model=own,
        unpressed=unpressed(model, markers, backbone),
        torque_per_pascal=1.0 / actuator.chamber_slopes,
        state=at_rest(model),
        load=make_load(rods),
        work=make_work(rods),
        integrator=twin.integrator,
        creeping=own._replace(k=model.k * (1.0 + sum(twin.creep))),
        implicit_work=make_implicit_work(rods),
        dt=dt,
        substeps=substeps_of(twin, tightest, dt, actuator.u_max),
        sheet=Sheet(twin.friction, twin.slip, np.zeros((2, rods))),
        creep=Creep(np.array(twin.creep), np.array(twin.creep_time), np.tile(bends, (2, 1))),
        hysteresis=Hysteresis(twin.hysteresis, twin.hysteresis_bend / rods, np.zeros(rods), bends.copy()),
        chambers=pneumatics,
        camera=camera(twin, dt),
        faults=faults(twin, pneumatics),
        markers=markers,
        backbone=backbone,
        ticks=np.zeros(1, np.int64),
        seed=np.array([twin.seed], np.uint64),
    )


def substeps_of(twin: TwinParameters, tightest: RodModel, dt: float, u_max: float) -> int:
    """One implicit step a tick; of RK4 as many as are wanted, and as its fastest mode needs."""
    if twin.integrator == Integrator.IMPLICIT:
        return 1
    return max(twin.substeps, stable_substeps(tightest, dt, u_max))


def twin_model(actuator: Actuator, twin: TwinParameters) -> RodModel:
    """The twin's chain: stiffness and gravity times kappa, damping given by zeta of its first mode.

    Without zeta it is damped as the actuator's own, whose damping ratios kappa does not change. Its `compliance` maps
    torques in the model's units, before kappa and the torque gain.
    """
    model = build_rod(bent(actuator, twin.set_curvature), twin.rods)
    k, g = model.k * twin.kappa * twin.stiffness_scale, model.g * twin.kappa
    rest, _ = equilibrium(ChainStatics(model.L, model.arm, model.m, k, model.bend, g), model.T_theta)
    if twin.zeta is None:
        pace = math.sqrt(twin.kappa)
        return model._replace(k=k, b=model.b * pace, alpha=model.alpha * pace, g=g, rest=rest)
    return damped(model._replace(k=k, g=g, rest=rest), twin.zeta)
