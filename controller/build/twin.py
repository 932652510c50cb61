"""The simulated plant, from parameters to arrays."""

import math

import numpy as np

from controller.build.equilibrium import ChainStatics, equilibrium
from controller.build.rod import build_rod, computable, profile
from controller.build.stability import natural_modes, sensor_places, stable_substeps
from controller.kernels.model.friction import Hysteresis, Sheet
from controller.kernels.model.rod import RodModel, make_load, make_work
from controller.kernels.model.statics import at_rest, places
from controller.kernels.plant.faults import Faults
from controller.kernels.plant.twin import Camera, Creep, Twin
from controller.kernels.plant.valve import REFERENCE_PRESSURE, Chambers, Valve, valve_flow
from controller.schema.actuator import Actuator
from controller.schema.parameters import BACKBONE_POINTS, SENSORS, RigParameters, TwinParameters

TWIN_BETA = 1.5e-4
"""Stiffness-proportional damping of the twin: small, so that fine rods stay cheap [s]."""
FAULT_SEED = 0x5EED
"""Parts the randomness of injected faults from the twin's own."""
TUNED_PRESSURE = 60e3
"""Gauge pressure at which the pressure loops have their nominal lags: of an ordinary step [Pa]."""


def build_twin(parameters: RigParameters) -> Twin:
    """The simulated plant of `parameters`, at rest, with the substeps that its fastest mode needs.

    Raises ParameterError where it has no rest, is too fast to be computed in time, or where numbers run over.
    """
    with computable(parameters.actuator):
        return _built(parameters)


def _built(parameters: RigParameters) -> Twin:
    twin, actuator, dt = parameters.twin, parameters.actuator, parameters.controller.dt
    model = twin_model(actuator, twin)
    stiffest = model._replace(k=model.k * (1.0 + sum(twin.creep) + twin.hysteresis))
    rods, length, bends = twin.rods, actuator.length, np.diff(model.rest, prepend=0.0)
    period, latency = max(1, round(twin.marker_period / dt)), round(twin.marker_latency / dt)
    waiting = latency // period + 1
    pneumatics = chambers(parameters)
    return Twin(
        model=model,
        state=at_rest(model),
        load=make_load(rods),
        work=make_work(rods),
        dt=dt,
        substeps=max(twin.substeps, stable_substeps(stiffest, dt, actuator.u_max)),
        sheet=Sheet(twin.friction, twin.slip, np.zeros((2, rods))),
        creep=Creep(np.array(twin.creep), np.array(twin.creep_time), np.tile(bends, (2, 1))),
        hysteresis=Hysteresis(twin.hysteresis, twin.hysteresis_bend / rods, np.zeros(rods), bends.copy()),
        chambers=pneumatics,
        camera=Camera(
            markers=sensor_places(model),
            noise=twin.marker_noise,
            period=period,
            latency=latency,
            t_ns=np.zeros(waiting, np.int64),
            points=np.zeros((waiting, SENSORS, 2)),
        ),
        faults=Faults(
            values=np.zeros(5),
            rods=np.zeros(1, np.int64),
            freeze=np.zeros(1, np.int64),
            pneumatics=pneumatics.broken,
            seed=np.array([twin.seed ^ FAULT_SEED], np.uint64),
        ),
        backbone=places(model, length * np.arange(BACKBONE_POINTS) / (BACKBONE_POINTS - 1)),
        ticks=np.zeros(1, np.int64),
        seed=np.array([twin.seed], np.uint64),
    )


def chambers(parameters: RigParameters) -> Chambers:
    """Four empty chambers; their loops have been on for long, so that the spools' offset is made up for."""
    twin, dt = parameters.twin, parameters.controller.dt
    return Chambers(
        pressure=np.zeros(4),
        sensed=np.zeros(4),
        spool=np.full(4, -twin.valve_offset),
        integral=np.full(4, -twin.valve_offset),
        line=np.zeros((round(twin.dead_time / dt) + 1, 4)),
        valve=tuned_valve(twin, dt),
        broken=np.zeros(3, np.int64),
        torque_per_pascal=twin.kappa * np.array(twin.torque_gain) / np.array(parameters.actuator.pressure_map),
    )


def tuned_valve(twin: TwinParameters, dt: float) -> Valve:
    """The valves with the gains that close the loop at TUNED_PRESSURE with the lags asked for.

    A gain for each direction, because one that suits the supply's choked flow would exhaust several times more slowly,
    and the paper's observer has one lag for both.
    """
    valve = Valve(
        supply=twin.supply_pressure,
        conductance=twin.conductance,
        critical_ratio=twin.critical_ratio,
        volume=twin.chamber_volume,
        keep=math.exp(-dt / twin.valve_lag) if twin.valve_lag > 0.0 else 0.0,
        offset=twin.valve_offset,
        inflate_gain=0.0,
        exhaust_gain=0.0,
        integral_time=twin.valve_integral_time,
    )
    filling, emptying = (
        REFERENCE_PRESSURE / twin.chamber_volume * abs(valve_flow(valve, opening, TUNED_PRESSURE))
        for opening in (1.0, -1.0)
    )
    return valve._replace(
        inflate_gain=1.0 / (twin.inflate_time * filling), exhaust_gain=1.0 / (twin.exhaust_time * emptying)
    )


def twin_model(actuator: Actuator, twin: TwinParameters) -> RodModel:
    """The twin's chain: stiffness and gravity times kappa, damping given by zeta of its first mode and TWIN_BETA.

    Its `compliance` maps torques in the model's units, before kappa and the torque gain.
    """
    model = build_rod(bent(actuator, twin), twin.rods)
    k, g = model.k * twin.kappa * twin.stiffness_scale, model.g * twin.kappa
    rest, _ = equilibrium(ChainStatics(model.L, model.arm, model.m, k, model.bend, g), model.T_theta)
    loose = model._replace(k=k, b=np.zeros(twin.rods), alpha=0.0, g=g, rest=rest)
    omega = float(np.abs(natural_modes(loose, rest)).min())
    return loose._replace(b=TWIN_BETA * k, alpha=max(0.0, 2.0 * twin.zeta * omega - TWIN_BETA * omega**2))


def bent(actuator: Actuator, twin: TwinParameters) -> Actuator:
    """`actuator` with the set of the plant added to its curvature at rest: one number for each half."""
    table = actuator.table_rods
    known = profile(actuator.rest_curvature, table)
    halves = np.array(twin.set_curvature)[2 * np.arange(table) // table]
    return actuator.model_copy(update={"rest_curvature": tuple(known + halves)})
