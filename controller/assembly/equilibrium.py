"""Where the unactuated body comes to rest, and how it bends from there: springs against gravity."""

from typing import NamedTuple

import numpy as np

from controller.arrays import Array
from controller.errors import ParameterError
from controller.kernels.model import equilibrium as kernels
from controller.kernels.model.equilibrium import Body
from controller.kernels.model.rod import RodModel

STAGES = 20
"""Gravity is brought up in this many steps: Newton then starts near the branch that the body really takes."""


class ChainStatics(NamedTuple):
    """What of a rod chain (base first, N rods) decides its statics; symbols as in RodModel."""

    L: Array
    arm: Array
    m: Array
    k: Array
    bend: Array
    g: Array


def equilibrium(body: ChainStatics, T_theta: Array) -> tuple[Array, Array]:
    """Angles at rest (N,) [rad] and their slope by u, K^-1 T_theta (N,2) [rad/(N m)]; K contains gravity's stiffness.

    Without gravity the angles are linear in u and this is all of the static map; with it, it is its tangent at rest.
    Raises ParameterError where the pose is not stable: gravity then buckles the body, and there is no one rest.
    """
    theta, whole = np.cumsum(body.bend), body_of(body)
    try:
        for stage in range(1, STAGES + 1) if body.g.any() else ():
            theta = settle(whole._replace(weight=stage / STAGES * whole.weight), theta)
        return theta, solve(body, theta, T_theta)
    except np.linalg.LinAlgError as error:
        raise ParameterError(
            f"gravity = {tuple(body.g.tolist())} m/s^2: the unactuated body has no stable rest: it has one where it "
            "is stiffer, shorter or lighter, or hangs"
        ) from error


def settle(body: Body, theta: Array) -> Array:
    """Newton's iteration from theta to where the torques of springs and gravity cancel; LinAlgError where it fails."""
    found = np.array(theta, dtype=float)
    if not kernels.settle(body, found, np.empty(found.size), np.empty(found.size)):
        raise np.linalg.LinAlgError("the stiffness is not positive definite, or no convergence")
    return found


def carrying(body: Body, torque: Array) -> Body:
    """The body under a torque on each of its angles (N,) [N m], which is more bend of every spring that carries it."""
    return body._replace(bend=body.bend + np.cumsum(torque[::-1])[::-1] / body.k)


def body_of(chain: ChainStatics | RodModel) -> Body:
    """What the kernels want to know of a chain on which no u acts."""
    none = np.zeros((0, 2))
    return Body(chain.k, chain.bend, np.zeros((chain.k.size, 2)), gravity_arms(chain) * chain.g[:, None], none, none)


def driven_body(model: RodModel) -> Body:
    """The same with what u does to it: its torques, and what its pressures make of stiffness and lengths."""
    return body_of(model)._replace(T_theta=model.T_theta, stiffening=model.stiffening, stretching=model.stretching)


def gravity_arms(body: ChainStatics | RodModel) -> Array:
    """Torque on each angle (N,) per gravity across its rod [kg m]: each rod carries all that hangs on it."""
    beyond = np.cumsum(body.m[::-1])[::-1] - body.m
    return np.asarray(body.L * beyond + body.m * body.arm)


def gravity_torque(body: ChainStatics | RodModel, theta: Array) -> tuple[Array, Array]:
    """Generalised force on the angles (N,) [N m] and its slope (N,)."""
    arm = gravity_arms(body)
    s, c = np.sin(theta), np.cos(theta)
    return np.asarray(arm * (body.g[1] * c - body.g[0] * s)), np.asarray(-arm * (body.g[0] * c + body.g[1] * s))


def imbalance(chain: ChainStatics | RodModel, theta: Array) -> Array:
    """Torque on each angle (N,) [N m] of springs and gravity."""
    torque = np.zeros(theta.size)
    kernels.imbalance(body_of(chain), 0.0, 0.0, theta, torque)
    return torque


def solve(chain: ChainStatics | RodModel, theta: Array, right: Array) -> Array:
    """K^-1 right, (N,) or (N,m): K of springs and gravity; LinAlgError where it is not positive definite."""
    pivot, x = np.zeros(theta.size), np.array(right.T, dtype=float, order="C")
    if not kernels.factor(body_of(chain), theta, pivot):
        raise np.linalg.LinAlgError("the stiffness is not positive definite")
    for column in np.atleast_2d(x):
        kernels.solve(chain.k, pivot, column)
    return np.ascontiguousarray(x.T)
