"""From parameters to the arrays that one tick works on: the bridge between pydantic and the kernels."""

import math

import numpy as np

from controller.arrays import Record
from controller.assembly.controllers.slot import build_slot
from controller.assembly.rod import computable, stiffest
from controller.assembly.stability import backbone_places, largest_gains, sensor_places
from controller.assembly.statics import observer_model, static_map
from controller.errors import ParameterError
from controller.kernels.control.tick import Rig
from controller.kernels.memory import PLAN, STATE, Control, Sensing
from controller.kernels.model.energy import make_ledger, open_ledger
from controller.kernels.model.equilibrium import make_scratch
from controller.kernels.model.implicit import make_implicit_work
from controller.kernels.model.pressed import owning, unpressed
from controller.kernels.model.rod import RodModel, make_load, make_work
from controller.kernels.model.statics import at_rest, points_on
from controller.kernels.observer.alpha_beta import AlphaBeta
from controller.kernels.observer.observer import Observer, make_reseat_state
from controller.kernels.observer.prediction import NOISE_VARIANCE, Prediction, reset_prediction
from controller.schema.actuator import Actuator
from controller.schema.layout import to_record
from controller.schema.modes import Cause, Integrator, RowKind
from controller.schema.parameters import (
    OBSERVER_DAMPING_MAX,
    OBSERVER_GAIN_MAX,
    REFERENCE_ROWS,
    SENSORS,
    ControllerParameters,
    RigParameters,
    SafetyLimits,
)

SAMPLES_APART_MIN = 1e-3
"""Of the fastest cameras: what is usual of the one at hand is learnt from there [s]."""
PULL_MAX = 10.0
"""Most force of an observer's spring over what full torque makes at the tip of a straight arm."""
REST_TIME_MAX = 60.0
"""Longest that REST may take: what was to vent would stay under pressure [s]."""


def build_rig(parameters: RigParameters, boot: int) -> Rig:
    """The controller's memory for one boot of a rig with boot id `boot`: vented, at rest, nothing planned.

    Raises ParameterError as `observer_model` does, and where numbers run over.
    """
    with computable(parameters.actuator):
        return _built(parameters, boot)


def _built(parameters: RigParameters, boot: int) -> Rig:
    controller, actuator = parameters.controller, parameters.actuator
    require_pressure(actuator, parameters.limits)
    require_rest(actuator, controller)
    model = observer_model(actuator, controller)
    gains_max, old = observer_gains_max(model, parameters), parameters.limits.measurement_old
    observer = build_observer(model, controller, gains_max, PULL_MAX * actuator.u_max / actuator.length, old)
    state = np.zeros(1, STATE)
    state["boot"] = boot
    state["cause"] = Cause.START
    state["kind"] = RowKind.DRAWN
    control = Control(
        dt=controller.dt,
        controller=to_record(controller),
        limits=limits_of(parameters),
        pascal_per_torque=actuator.chamber_slopes,
        smap=static_map(actuator, controller),
        scratch=make_scratch(controller.rods),
        q=observer.state.q,
        v=observer.state.v,
        reference=np.zeros((REFERENCE_ROWS, 2)),
        slot=build_slot(REFERENCE_ROWS),
        guide=np.zeros((REFERENCE_ROWS, 2)),  # written with every reference: memory that nothing has touched is none
        kinds=np.full(REFERENCE_ROWS, RowKind.DRAWN, np.uint8),
        plan=np.zeros(1, PLAN),
        state=state,
    )
    return Rig(control, observer, no_sample())


def require_pressure(actuator: Actuator, limits: SafetyLimits) -> None:
    """Raise ParameterError if full torque takes a pressure at which the rig stops itself."""
    needed = actuator.u_max * max(actuator.chamber_slopes)
    if needed > limits.pressure_max:
        raise ParameterError(
            f"u_max = {actuator.u_max} N m needs {needed:.0f} Pa: an E-STOP of the rig, above its limit of "
            f"{limits.pressure_max:.0f} Pa"
        )


def limits_of(parameters: RigParameters) -> Record:
    """The limits as the loop has them: a body with less inertia is as much faster when a marker jumps."""
    limits = to_record(parameters.limits)
    limits["speed_max"] *= math.sqrt(parameters.controller.observer_kappa)
    return limits


def require_rest(actuator: Actuator, controller: ControllerParameters) -> None:
    """Raise ParameterError if REST takes too long to bring full torque to zero."""
    needed = actuator.u_max / controller.rest_rate
    if needed > REST_TIME_MAX:
        raise ParameterError(
            f"rest_rate = {controller.rest_rate:g} N m/s takes {needed:.4g} s to bring u_max = {actuator.u_max:g} N m "
            f"to rest, more than {REST_TIME_MAX:g} s"
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
        usual=np.full(1, SAMPLES_APART_MIN),
        gap=np.zeros(1),
        held=np.zeros(1),
        late=np.zeros(1),
        age=np.zeros(1),
        off=unknown,
        fast=np.zeros(1),
        met_ns=np.zeros(SENSORS, np.int64),
        dropped=np.zeros(1, np.int64),
    )


def observer_gains_max(model: RodModel, parameters: RigParameters) -> tuple[float, float]:
    """Most K_o [N/m] and B_o [N s/m] with which `model` is stable; ParameterError where it is with none."""
    controller = parameters.controller
    if controller.integrator == Integrator.IMPLICIT:
        return OBSERVER_GAIN_MAX, OBSERVER_DAMPING_MAX
    u_max = parameters.actuator.u_max
    return largest_gains(model._replace(k=stiffest(model, u_max)), controller.dt, u_max)


def build_observer(
    model: RodModel, controller: ControllerParameters, gains_max: tuple[float, float], pull_max: float, old: float
) -> Observer:
    """Observer of `model` at rest; one step of its integrator a period. `gains_max` of `observer_gains_max`.

    No spring pulls with more than `pull_max` [N], and samples older than `old` [s] are not used.
    """
    own, rods = owning(model), model.L.size
    sensors, backbone = sensor_places(model), backbone_places(model)
    state, ledger = at_rest(model), make_ledger()
    open_ledger(model, state, ledger)
    least = controller.observer_beta * model.k if controller.integrator == Integrator.IMPLICIT else 0.0
    observer = Observer(
        model=own._replace(b=model.b.copy()),
        state=state,
        load=make_load(rods, SENSORS),
        integrator=int(controller.integrator),
        work=make_work(rods),
        implicit_work=make_implicit_work(rods, SENSORS),
        ledger=ledger,
        dt=controller.dt,
        damping=np.array([model.b, np.maximum(model.b, least)]),
        damped=np.array([rods]),
        pull_max=pull_max,
        gain_max=np.array(gains_max),
        dead_time=np.zeros((round(controller.dead_time / controller.dt) + 1, 2)),
        head=np.zeros(1, np.int64),
        lag=controller.pneumatic_lag,
        u_hat=np.zeros(2),
        level_hat=np.zeros(2),
        torque=np.zeros(2),
        level=np.zeros(2),
        unpressed=unpressed(model, sensors, backbone),
        sensors=sensors,
        backbone=backbone,
        points=np.zeros((SENSORS, 2)),
        seat=make_reseat_state(rods, SENSORS),
        predicts=controller.carry_on and controller.predict,
        prediction=no_prediction(own, round(old / controller.dt) + 2),
    )
    points_on(observer.state.q, observer.sensors, observer.points)
    reset_prediction(observer.state, observer.sensors, observer.prediction)
    return observer


def free_model(model: RodModel, controller: ControllerParameters) -> Observer:
    """`model` in the observer's place, driven by torques alone, through the observer's dead time and lag."""
    return build_observer(model, controller, (OBSERVER_GAIN_MAX, OBSERVER_DAMPING_MAX), 0.0, 0.0)


def no_prediction(model: RodModel, ticks: int) -> Prediction:
    """Before the first sample; samples may be up to `ticks` old. `model`, the observer's, shares its stiffness."""
    p, v = np.zeros((2, SENSORS, 2))
    return Prediction(
        model=model,
        state=at_rest(model),
        load=make_load(model.L.size),
        trail=np.zeros((ticks, SENSORS, 2)),
        newest=np.zeros(1, np.int64),
        off=no_points(),
        alone=no_points(),
        taken_ns=np.zeros(SENSORS, np.int64),
        sample_ns=np.zeros(1, np.int64),
        before=np.full((3, SENSORS, 2), math.nan),
        noise=np.full(SENSORS, NOISE_VARIANCE[1]),
        p=p,
        v=v,
    )


def no_points() -> AlphaBeta:
    """Before the first sample."""
    x, rate = np.zeros((2, SENSORS, 2))
    return AlphaBeta(x, rate, np.full(SENSORS, NOISE_VARIANCE[1]))
