"""What every simulated plant has around its rod: chambers behind valves, a camera, faults, a set in its curvature."""

import math

import numpy as np

from controller.arrays import Array
from controller.assembly.rod import build_rod, profile
from controller.assembly.stability import slowest
from controller.kernels.plant.camera import Camera
from controller.kernels.plant.faults import Faults
from controller.kernels.plant.valve import REFERENCE_PRESSURE, Chambers, PressureLoop, Valve, valve_flow
from controller.schema.actuator import Actuator
from controller.schema.parameters import SENSORS, RigParameters, TwinParameters

FAULT_SEED = 0x5EED
"""Parts the randomness of injected faults from the twin's own."""
TUNED_PRESSURE = 60e3
"""Gauge pressure at which the pressure loops have their nominal lags: of an ordinary step [Pa]."""


Halves = tuple[float, float]
"""A number of each pair of chambers, or of each half of the body."""


def chambers(parameters: RigParameters, torque_gain: Halves, imbalance: Halves = (0.0, 0.0)) -> Chambers:
    """Four empty chambers; their loops have been on for long, so that the spools' offset is made up for."""
    twin, dt = parameters.twin, parameters.controller.dt
    return Chambers(
        pressure=np.zeros(4),
        sensed=np.zeros(4),
        spool=np.full(4, -twin.valve_offset),
        integral=np.full(4, -twin.valve_offset),
        line=np.zeros((round(twin.dead_time / dt) + 1, 4)),
        raw=np.zeros(1, np.int64),
        valve=tuned_valve(twin, dt),
        broken=np.zeros(3, np.int64),
        torque_per_pascal=twin.kappa * chamber_gains(torque_gain, imbalance) / parameters.actuator.chamber_slopes,
    )


def chamber_gains(torque_gain: Halves, imbalance: Halves) -> Array:
    """By how much the chambers u1+, u1-, u2+, u2- (4,) bend the plant more than their `chamber_slopes` say [1]."""
    apart = np.array(imbalance)
    return np.asarray(np.repeat(torque_gain, 2) * (1.0 + np.column_stack([apart, -apart]).ravel()))


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
        loop=PressureLoop(inflate_gain=0.0, exhaust_gain=0.0, integral_time=twin.valve_integral_time),
    )
    filling, emptying = (
        REFERENCE_PRESSURE / twin.chamber_volume * abs(valve_flow(valve, opening, TUNED_PRESSURE))
        for opening in (1.0, -1.0)
    )
    gains = {"inflate_gain": 1.0 / (twin.inflate_time * filling), "exhaust_gain": 1.0 / (twin.exhaust_time * emptying)}
    return valve._replace(loop=valve.loop._replace(**gains))


def camera(twin: TwinParameters, dt: float) -> Camera:
    """The markers' camera, before its first sample."""
    period, latency = max(1, round(twin.marker_period / dt)), round(twin.marker_latency / dt)
    waiting = latency // period + 1
    return Camera(
        noise=twin.marker_noise,
        period=period,
        latency=latency,
        t_ns=np.zeros(waiting, np.int64),
        points=np.zeros((waiting, SENSORS, 2)),
    )


def faults(twin: TwinParameters, pneumatics: Chambers) -> Faults:
    """No fault, yet."""
    return Faults(
        values=np.zeros(5),
        rods=np.zeros(1, np.int64),
        freeze=np.zeros(1, np.int64),
        pneumatics=pneumatics.broken,
        seed=np.array([twin.seed ^ FAULT_SEED], np.uint64),
    )


def damping_ratio(actuator: Actuator, twin: TwinParameters) -> float:
    """zeta of the plant's first mode: as it is given, or as b and alpha of the actuator make it."""
    return slowest(build_rod(actuator, actuator.table_rods))[1] if twin.zeta is None else twin.zeta


def bent(actuator: Actuator, set_curvature: Halves) -> Actuator:
    """`actuator` with the set of the plant added to its curvature at rest: one number for each half."""
    table = actuator.table_rods
    known = profile(actuator.rest_curvature, table)
    halves = np.array(set_curvature)[2 * np.arange(table) // table]
    return actuator.model_copy(update={"rest_curvature": tuple(known + halves)})
