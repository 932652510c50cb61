"""From parameters to the arrays that one tick works on: the bridge between pydantic and the kernels."""

import itertools
import math

import numpy as np

from controller.arrays import Array
from controller.build.rod import build_rod, computable
from controller.build.stability import require_stable
from controller.errors import ParameterError
from controller.kernels.control.tick import Rig
from controller.kernels.memory import PLAN, STATE, Control, Sensing
from controller.kernels.model.energy import make_ledger, open_ledger
from controller.kernels.model.implicit import make_implicit_work
from controller.kernels.model.polygon import Polygon, admissible
from controller.kernels.model.rod import RodModel, make_load, make_work
from controller.kernels.model.statics import StaticMap, at_rest, places, points_on, static_tip
from controller.kernels.observer.observer import Observer, ObserverGains, reset_observer, step_observer
from controller.schema.actuator import Actuator
from controller.schema.layout import to_record
from controller.schema.modes import Cause, Integrator, RowKind
from controller.schema.parameters import (
    BACKBONE_POINTS,
    REFERENCE_ROWS,
    SENSORS,
    ControllerParameters,
    RigParameters,
    SafetyLimits,
)

SEED_GRID = 41
"""Points a side of the grid of starts for the inverse: 3 mN m, some 10 mm at the tip."""


def build_rig(parameters: RigParameters, boot: int) -> Rig:
    """The controller's memory for one boot of a rig with boot id `boot`: vented, at rest, nothing planned.

    Raises ParameterError as `observer_model` does, and where numbers run over.
    """
    with computable(parameters.actuator):
        return _built(parameters, boot)


def _built(parameters: RigParameters, boot: int) -> Rig:
    controller, actuator = parameters.controller, parameters.actuator
    require_pressure(actuator, parameters.limits)
    model = observer_model(parameters)
    observer = build_observer(model, controller)
    state = np.zeros(1, STATE)
    state["boot"] = boot
    state["cause"] = Cause.START
    state["kind"] = RowKind.DRAWN
    control = Control(
        dt=controller.dt,
        controller=to_record(controller),
        limits=to_record(parameters.limits),
        pascal_per_torque=np.array(actuator.pressure_map),
        smap=build_static_map(model, actuator, controller),
        q=observer.state.q,
        v=observer.state.v,
        reference=np.zeros((REFERENCE_ROWS, 2)),
        guide=np.full((REFERENCE_ROWS, 2), math.nan),
        kinds=np.full(REFERENCE_ROWS, RowKind.DRAWN, np.uint8),
        plan=np.zeros(1, PLAN),
        state=state,
    )
    return Rig(control, observer, no_sample())


def require_pressure(actuator: Actuator, limits: SafetyLimits) -> None:
    """Raise ParameterError if full torque takes a pressure at which the rig stops itself."""
    needed = actuator.u_max * max(actuator.pressure_map)
    if needed > limits.pressure_max:
        raise ParameterError(
            f"u_max = {actuator.u_max} N m needs {needed:.0f} Pa: an E-STOP of the rig, above its limit of "
            f"{limits.pressure_max:.0f} Pa"
        )


def no_sample() -> Sensing:
    """Before the first sample of the markers."""
    unknown = np.full((SENSORS, 2), math.nan)
    return Sensing(
        sample_ns=np.zeros(1, np.int64),
        p=unknown.copy(),
        v=np.zeros((SENSORS, 2)),
        seen=unknown.copy(),
        seen_dot=np.zeros((SENSORS, 2)),
        age=np.zeros(1),
        off=unknown,
        fast=np.zeros(1),
        met_ns=np.zeros(SENSORS, np.int64),
        dropped=np.zeros(1, np.int64),
    )


def observer_model(parameters: RigParameters) -> RodModel:
    """The observer's chain. Raises ParameterError where it has no rest, or no stable motion with its integrator."""
    controller, actuator = parameters.controller, parameters.actuator
    model = build_rod(actuator, controller.rods, omega_B=controller.omega_B, zeta_B=controller.zeta_B)
    if controller.integrator == Integrator.RK4:
        require_stable(model, controller.dt, actuator.u_max)
    return model


def build_observer(model: RodModel, controller: ControllerParameters) -> Observer:
    """Observer of `model` at rest; one step of its integrator a period."""
    length, rods = float(model.L.sum()), model.L.size
    state, ledger = at_rest(model), make_ledger()
    open_ledger(model, state, ledger)
    observer = Observer(
        model=model,
        state=state,
        load=make_load(rods),
        integrator=int(controller.integrator),
        work=make_work(rods),
        implicit_work=make_implicit_work(rods),
        ledger=ledger,
        dt=controller.dt,
        gains=ObserverGains(np.zeros(2), np.zeros(2)),
        B_max=math.inf,
        dead_time=np.zeros((round(controller.dead_time / controller.dt) + 1, 2)),
        head=np.zeros(1, np.int64),
        lag=controller.pneumatic_lag,
        u_hat=np.zeros(2),
        sensors=places(model, length * np.arange(1, SENSORS + 1) / SENSORS),
        backbone=places(model, length * np.arange(BACKBONE_POINTS) / (BACKBONE_POINTS - 1)),
        points=np.zeros((SENSORS, 2)),
    )
    B_max = largest_damping(observer)
    points_on(observer.state.q, observer.sensors, observer.points)
    return observer._replace(B_max=B_max)


def largest_damping(observer: Observer) -> float:
    """The damping [N s/m] with which a force at the tip's rod would stop the tip in the step for which it is held."""
    last = observer.model.L.size - 1
    s, c = math.sin(observer.model.rest[last]), math.cos(observer.model.rest[last])
    observer.load.F[:, last] = -s, c
    kick = observer.state
    step_observer(observer)
    tip = kick.v[:2, last] + (observer.model.L[last] - observer.model.arm[last]) * kick.v[2, last] * np.array([-s, c])
    observer.load.F[:] = 0.0
    reset_observer(observer)
    return 1.0 / float(np.hypot(*tip))


def build_polygon(actuator: Actuator, bend: Array) -> Polygon:
    """Admissible torques of `actuator`; `bend` (2,) [rad/(N m)] is the tip angle per torque."""
    normals = np.array([[1.0, 0.0], [0.0, 1.0], bend])
    bounds = np.array([actuator.u_max, actuator.u_max, actuator.bend_max])
    open_polygon = Polygon(normals, bounds, np.zeros((0, 2)))
    corners = []
    for first, second in itertools.combinations(range(3), 2):
        for sign, other in itertools.product((-1.0, 1.0), repeat=2):
            sides = np.array([sign * bounds[first], other * bounds[second]])
            corner = np.linalg.solve(normals[[first, second]], sides)
            if admissible(open_polygon, corner[0], corner[1]):
                corners.append(corner)
    corners.sort(key=lambda corner: math.atan2(corner[1], corner[0]))
    return Polygon(normals, bounds, np.array(corners))


def build_static_map(model: RodModel, actuator: Actuator, controller: ControllerParameters) -> StaticMap:
    """Static map of `model` over the torques of `actuator`, with a grid of starts."""
    polygon = build_polygon(actuator, model.compliance[-1])
    side = np.linspace(-actuator.u_max, actuator.u_max, SEED_GRID)
    grid = [(u1, u2) for u1 in side for u2 in side if admissible(polygon, u1, u2)]
    tips = [static_tip(model, u1, u2) for u1, u2 in grid]
    return StaticMap(
        L=model.L,
        rest=model.rest,
        compliance=model.compliance,
        polygon=polygon,
        epsilon=controller.epsilon,
        rcond_min=controller.rcond_min,
        seeds=np.array(grid),
        seed_tips=np.array(tips),
    )
