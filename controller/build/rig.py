"""From parameters to the arrays that one tick works on: the bridge between pydantic and the kernels."""

import math

import numpy as np

from controller.build.rod import build_rod, computable
from controller.build.stability import require_stable
from controller.build.statics import build_static_map
from controller.errors import ParameterError
from controller.kernels.control.tick import Rig
from controller.kernels.memory import PLAN, STATE, Control, Sensing
from controller.kernels.model.energy import make_ledger, open_ledger
from controller.kernels.model.equilibrium import make_scratch
from controller.kernels.model.implicit import make_implicit_work
from controller.kernels.model.rod import RodModel, make_load, make_work
from controller.kernels.model.statics import at_rest, places, points_on
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
        scratch=make_scratch(controller.rods),
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
