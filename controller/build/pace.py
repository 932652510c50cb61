"""The observer's body with the inertia that its arm was measured to have, and how far that may go under gravity."""

import math
from collections.abc import Callable

import numpy as np

from controller.arrays import Array
from controller.build.rod import build_rod
from controller.build.stability import largest_modulus, move, slopes
from controller.errors import ParameterError
from controller.kernels.model.implicit import implicit_step, make_implicit_work
from controller.kernels.model.rod import RodModel, make_load
from controller.kernels.model.statics import at_rest
from controller.schema.actuator import Actuator
from controller.schema.modes import Integrator
from controller.schema.parameters import ControllerParameters

MOST_RODS = 60
"""Of the chain that is looked at: finer ones are stiffer where they move faster, and the step lets that die at once."""
CALM = 1.0 + 1e-7
"""Growth in a tick that counts as none: an e-fold takes three hours."""
ALPHA_LEAST, ALPHA_MOST = 1e-6, 50.0
"""Mass-proportional damping [1/s] between which the least is looked for; more is in no actuator's file."""
SPARE = 5.0
"""As many times the kappa has to be calm hanging straight: held and bent, a body may be worse by some of that."""
NEAR = 1.01
"""Ratio to which a bound is found."""


def hastened(model: RodModel, kappa: float) -> RodModel:
    """`model` with its inertia over `kappa`: the same statics and damping ratios, motions kappa^(1/2) times as fast."""
    m, I, pace = model.m / kappa, model.I / kappa, math.sqrt(kappa)  # noqa: E741
    return model._replace(
        m=m, I=I, m_inv=1 / m, I_inv=1 / I, g=model.g * kappa, b=model.b / pace, alpha=model.alpha * pace
    )


def require_calm(actuator: Actuator, controller: ControllerParameters) -> None:
    """Raise ParameterError where gravity would make the observer's motions grow, with what would let them die out.

    The implicit step's energy law has one gap, gravity's work on closing the hinges (`implicit_step`): damping has to
    be more than that, and less inertia makes it more. RK4 has a bound of its own.
    """
    if not any(actuator.gravity) or controller.integrator != Integrator.IMPLICIT:
        return
    kappa, dt = controller.observer_kappa, controller.dt
    model = hanging(build_rod(actuator, min(controller.rods, MOST_RODS)))
    where = f"the observer's motions die out under gravity, with {controller.rods} rods and dt = {dt:g} s"
    if not calm(model._replace(alpha=ALPHA_MOST), dt):
        raise ParameterError(f"dt = {dt:g} s is too long: with no alpha up to {ALPHA_MOST:g} 1/s {where}")
    if not calm(model, dt):
        least = bound(lambda alpha: calm(model._replace(alpha=alpha), dt), ALPHA_MOST, max(model.alpha, ALPHA_LEAST))
        raise ParameterError(f"alpha = {actuator.alpha:g} 1/s is below {least:.3g}, the least with which {where}")
    if kappa > 1.0 and not calm(hastened(model, SPARE * kappa), dt):
        most = max(1.0, bound(lambda one: calm(hastened(model, SPARE * one), dt), 1.0 / SPARE, kappa))
        raise ParameterError(f"observer_kappa = {kappa:g} is above {most:.3g}, the most with which {where}")


def bound(holds: Callable[[float], bool], good: float, bad: float) -> float:
    """The number beside `bad`, within 1 %, for which `holds` is true, as it is for `good`; between both, by ratios."""
    while max(good / bad, bad / good) > NEAR:
        middle = math.sqrt(good * bad)
        good, bad = (middle, bad) if holds(middle) else (good, middle)
    return good


def calm(model: RodModel, dt: float) -> bool:
    """Whether no small motion of `model` grows with steps of dt [s]."""
    return growth(model, dt) <= CALM


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

    return largest_modulus(slopes(after, 2 * rods))
