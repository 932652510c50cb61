"""Figures of `tendril stability`: how the observer's and the loop's small motions grow, at worst over the reach."""

import cmath
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from controller.arrays import Array
from controller.assembly.rig import build_rig
from controller.assembly.stability import move
from controller.assembly.twin import build_twin
from controller.errors import ParameterError
from controller.kernels.control.feedback import told_of_tip
from controller.kernels.control.task_space import update_sensitivity
from controller.kernels.control.tick import Rig
from controller.kernels.model.polygon import admissible
from controller.kernels.model.statics import places, points_on, static_pose
from controller.kernels.observer.alpha_beta import ALPHA_MAX, ALPHA_MIN
from controller.research.stability.chain_step import (
    by_state,
    draw,
    free_step,
    largest_modulus,
    observer_step,
    plant_step,
    rest_of,
)
from controller.research.stability.closed_loop import LIBRARY, ByHand, Chains, Growth, Loop, Timing, feedback
from controller.schema.modes import Integrator, RowKind
from controller.schema.parameters import SENSORS, RigParameters, Settings

SIDE, FEW_SIDE = 5, 3
"""Torques a side of the grid over the reach, few with more rods than MANY; the corners of the polygon come on top."""
MANY = 60
"""The loop is looked at with this many rods where there are more: what they add has died out within a tick."""
GAIN_MOST, DELAY_MOST = 1000.0, 0.2
"""The largest factor on the torque, and the most additional delay [s], that margins are looked for up to."""


@dataclass(frozen=True)
class Question:
    """What is asked for; `sensed` counts sensors from 0."""

    parameters: RigParameters
    sensed: tuple[int, ...]
    K_o: float
    B_o: float
    library: bool = False
    """Under the law of the library's shapes; else that of FOLLOW and HOLD, whose feedback lags."""


class Margins(NamedTuple):
    """How much more the loop takes on its way from the controller to the plant before it swings, at worst."""

    gain: float
    """Factor on both torques."""
    phase_deg: float
    """Lag of both [degrees]."""
    delay_ms: float


class Stability(NamedTuple):
    """As the JSON file has it. Growths are moduli per tick, at worst over the reach."""

    actuator: str
    rods: int
    integrator: str
    sense: list[int]
    k_o: float
    b_o: float
    accepted: bool
    """Whether the rig takes these gains."""
    largest_k_o: float
    """[N/m] that the rig takes."""
    largest_b_o: float
    """[N s/m]."""
    growth: float
    """Of the observer alone."""
    growth_at: tuple[float, float]
    """Torques there [N m]."""
    closed_loop_growth: float
    """With the twin as the plant and the default law and gains."""
    closed_loop_stable: bool
    """Whether it swings up nowhere, and drifts away only at less than a tenth per second."""
    margins: Margins


def stability(question: Question) -> Stability:
    """Everything; ParameterError where the observer cannot run at all."""
    parameters, rig = question.parameters, build_rig(question.parameters, 1)
    observer, controller = rig.observer, parameters.controller
    growth, worst = max((growth_at(question, rig, u), tuple(u.tolist())) for u in grid(parameters, rig))
    K_most, B_most = observer.gain_max.tolist()
    loops = [loop for library in (False, True) for loop in every_loop(replace(question, library=library))]
    found = [loop.growth() for loop in loops]
    return Stability(
        actuator=parameters.actuator.name,
        rods=controller.rods,
        integrator=Integrator(controller.integrator).name,
        sense=[sensor + 1 for sensor in question.sensed],
        k_o=question.K_o,
        b_o=question.B_o,
        accepted=question.K_o <= K_most and question.B_o <= B_most,
        largest_k_o=K_most,
        largest_b_o=B_most,
        growth=growth,
        growth_at=worst,
        closed_loop_growth=max(one.all for one in found),
        closed_loop_stable=all(one.stable for one in found),
        margins=margins(loops, controller.dt) if all(one.stable for one in found) else Margins(0.0, 0.0, 0.0),
    )


def growth_at(question: Question, rig: Rig, u: Array) -> float:
    """Growth of the observer in its static pose at u (2,) [N m], with markers that fit. In place: rig."""
    observer, theta = rig.observer, own_pose(rig, u)
    points_on(observer.state.q, observer.sensors, observer.points)
    draw(observer, question.sensed, observer.points, u, (question.K_o, question.B_o))
    return largest_modulus(observer_step(observer, theta).A)


def own_pose(rig: Rig, u: Array) -> Array:
    """Angles (N,) of the model's static pose at u (2,) [N m]. In place: rig.observer.state, which takes it."""
    static_pose(rig.control.smap.statics, u[0], u[1], rig.control.scratch)
    theta = rig.control.scratch.theta.copy()
    move(rig.observer.model, theta, np.zeros(2 * theta.size), rig.observer.state)
    return theta


def every_loop(question: Question) -> Iterator[Loop]:
    """The loop linear about each pose of the grid: the plant's, and where the observer is drawn by its markers."""
    controller = question.parameters.controller
    fewer = controller.model_copy(update={"rods": min(controller.rods, MANY)})
    parameters = question.parameters.model_copy(update={"controller": fewer})
    rig, twin, settings = build_rig(parameters, 1), build_twin(parameters), Settings()
    observer, state = rig.observer, rig.control.state
    tip_alone = places(observer.model, np.array([float(observer.model.L.sum())]))
    state["kind"] = RowKind.KNOWN if question.library else RowKind.DRAWN
    timing = loop_timing(parameters, twin.camera.period, twin.camera.latency)
    tip = question.sensed.index(SENSORS - 1) if SENSORS - 1 in question.sensed else None
    told = told_of_tip(sum(1 << sensor for sensor in question.sensed), rig.control.controller[0])
    for u in grid(question.parameters, rig):
        plant, markers = plant_step(twin, u, question.sensed)
        own = own_pose(rig, u)
        draw(observer, question.sensed, markers, u, (question.K_o, question.B_o))
        free = free_step(observer, own, question.sensed)
        theta = rest_of(observer)
        seen = observer_step(observer, theta)._replace(P=by_state(observer.model, theta, tip_alone))
        observer.state.q[2] = theta
        state["u"] = u
        update_sensitivity(rig.control)
        S, share, weak = np.reshape(state["S"][0], (2, 2)), float(state["share"][0]), state["weak"][0]
        by_hand = LIBRARY if question.library else ByHand(controller.feedback_lag, told)
        law = feedback(S, share, weak, settings, controller.epsilon, by_hand)
        for one in timing:
            yield Loop(Chains(seen, free, plant), law, tip, one)


def grid(parameters: RigParameters, rig: Rig) -> Array:
    """Admissible torques (n,2) [N m]: a grid, and the corners."""
    side = SIDE if parameters.controller.rods <= MANY else FEW_SIDE
    line = parameters.actuator.u_max * np.linspace(-1.0, 1.0, side)
    polygon = rig.control.smap.polygon
    inside = [(u1, u2) for u1 in line for u2 in line if admissible(polygon, u1, u2)]
    return np.array([*inside, *polygon.corners])


def loop_timing(parameters: RigParameters, period: int, latency: int) -> list[Timing]:
    """The clocks of controller and twin, with the least and the most that the observer's filter of the markers takes.

    ParameterError where a sample comes later than the next one is taken.
    """
    controller, twin = parameters.controller, parameters.twin
    if latency >= period:
        raise ParameterError(
            f"twin.marker_latency = {twin.marker_latency:g} s: less than marker_period = {twin.marker_period:g} s"
        )
    one = Timing(
        dt=controller.dt,
        period=period,
        latency=latency,
        observer_delay=round(controller.dead_time / controller.dt),
        plant_delay=round(twin.dead_time / controller.dt),
        observer_lag=controller.pneumatic_lag,
        plant_lag=max(twin.inflate_time, twin.exhaust_time),
        carried=controller.carry_on,
        alpha=None,
    )
    if not (controller.carry_on and controller.predict):
        return [one]
    return [replace(one, alpha=alpha) for alpha in (ALPHA_MIN, ALPHA_MAX)]


def margins(loops: list[Loop], dt: float) -> Margins:
    """The smallest of all poses."""
    phase = smallest(loops, lambda loop, lag: loop.growth(cmath.exp(-1j * math.radians(lag))), 180.0, 0.05)
    gain = smallest(loops, lambda loop, x: loop.growth(math.exp(x)), math.log(GAIN_MOST), 1e-3)
    ticks = smallest(loops, lambda loop, d: loop.growth(more_delay=int(d)), round(DELAY_MOST / dt), 1.0)
    return Margins(math.exp(gain), phase, 1e3 * dt * int(ticks))


def smallest(loops: list[Loop], growth: Callable[[Loop, float], Growth], most: float, fine: float) -> float:
    """The largest change up to `most` that all loops take, to `fine`; each is asked at the smallest of those before."""
    bound = most
    for loop in loops:
        if growth(loop, bound).stable:
            continue
        low, high = 0.0, bound
        while high - low > fine:
            middle = (low + high) / 2.0
            low, high = (middle, high) if growth(loop, middle).stable else (low, middle)
        bound = low
    return bound
