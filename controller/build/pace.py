"""The observer's body with the inertia that its arm was measured to have, and how far that may go under gravity."""

import numpy as np

from controller.arrays import Array
from controller.build.rod import build_rod
from controller.build.stability import move
from controller.errors import ParameterError
from controller.kernels.model.implicit import implicit_step, make_implicit_work
from controller.kernels.model.rod import RodModel, make_load
from controller.kernels.model.statics import at_rest
from controller.schema.actuator import Actuator
from controller.schema.modes import Integrator
from controller.schema.parameters import OBSERVER_KAPPA, ControllerParameters

MOST_RODS = 60
"""Of the chain that is looked at: finer ones are stiffer where they move faster, and the step lets that die at once."""
DEVIATION = 1e-6
"""Angles [rad] and rates [rad/s] are moved by this."""
CALM = 1.0 + 1e-7
"""Growth in a tick that counts as none: an e-fold takes three hours."""


def hastened(model: RodModel, kappa: float) -> RodModel:
    """`model` with its inertia over `kappa`: the same statics and damping ratios, motions kappa^(1/2) times as fast."""
    m, I, pace = model.m / kappa, model.I / kappa, float(np.sqrt(kappa))  # noqa: E741
    return model._replace(
        m=m, I=I, m_inv=1 / m, I_inv=1 / I, g=model.g * kappa, b=model.b / pace, alpha=model.alpha * pace
    )


def require_calm(actuator: Actuator, controller: ControllerParameters) -> None:
    """Raise ParameterError where gravity would make the observer's motions grow with this `observer_kappa`.

    The implicit step's energy law has one gap, gravity's work on closing the hinges (`implicit_step`), and less inertia
    makes that more. RK4 has a bound of its own.
    """
    kappa = controller.observer_kappa
    if kappa == 1.0 or not any(actuator.gravity) or controller.integrator != Integrator.IMPLICIT:
        return
    model = hanging(build_rod(actuator, min(controller.rods, MOST_RODS)))
    if growth(hastened(model, kappa), controller.dt) <= CALM:
        return
    calm, wild = OBSERVER_KAPPA[0], kappa
    while wild > 1.01 * calm:
        middle = float(np.sqrt(calm * wild))
        if growth(hastened(model, middle), controller.dt) <= CALM:
            calm = middle
        else:
            wild = middle
    raise ParameterError(
        f"observer_kappa = {kappa:g} is above {calm:.3g}, the most with which the observer's motions die out under the "
        f"gravity of {actuator.name}, with its damping and {controller.rods} rods at dt = {controller.dt:g} s"
    )


def hanging(model: RodModel) -> RodModel:
    """`model` straight along its gravity, as which it is pulled most."""
    straight = np.zeros(model.L.size)
    return model._replace(g=np.array([np.hypot(*model.g), 0.0]), bend=straight, rest=straight)


def growth(model: RodModel, dt: float) -> float:
    """Largest growth of a small motion of `model` about its rest in a tick of dt [s]; 1 is none."""
    rods, state = model.L.size, at_rest(model)
    load, work = make_load(rods), make_implicit_work(rods)

    def after(deviation: Array) -> Array:
        move(model, model.rest, deviation, state)
        implicit_step(model, load, dt, state, work)
        return np.concatenate([state.q[2], state.v[2]])

    columns = [(after(DEVIATION * row) - after(-DEVIATION * row)) / (2.0 * DEVIATION) for row in np.eye(2 * rods)]
    return float(np.abs(np.linalg.eigvals(np.array(columns).T)).max())
