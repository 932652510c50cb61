"""Which torques held a body in the pose from which it was released."""

import numpy as np
from scipy.linalg import LinAlgError

from controller.arrays import Array
from controller.assembly.equilibrium import body_of, carrying, settle, solve
from controller.assembly.stability import point_slopes
from controller.kernels.model.equilibrium import Body
from controller.kernels.model.rod import RodModel
from controller.kernels.model.statics import Places, points_on, pose

NEAR = 2e-3
"""How near to the seen bodies the held pose must be: model and data differ by this much anyway [m]."""
ITERATIONS = 25
DONE = 1e-3
"""Steps below this share of a torque's scatter have converged."""


def torques_to(model: RodModel, arcs: Array) -> Array:
    """T_theta (N,m): a torque from the clamp to each of the arc lengths (m,) [m], shared by the rods about it."""
    middles = np.cumsum(model.L) - model.L / 2
    at = np.interp(arcs, middles, np.arange(middles.size))
    return np.asarray(np.maximum(0.0, 1.0 - np.abs(np.arange(middles.size)[:, None] - at)))


def held_pose(model: RodModel, T: Array, seen: Places, moved: Array, scatter: Array) -> tuple[Array, Array]:
    """Angles (N,) [rad] and torques on the rods (N,) [N m] of the likeliest held pose.

    `seen` are the sensed bodies and `moved` (s,2) [m] how far they are from their rest. Torques u (m,) through T (N,m)
    with the standard deviations `scatter` (m,) [N m] hold the pose: least squares of the misfit over NEAR and of
    u / scatter, by Gauss-Newton. Two coordinates of one body do not determine m torques; the scatter decides the rest.
    """
    body = body_of(model)
    goal = moved + positions(model, model.rest, seen)
    u, theta = np.zeros(scatter.size), model.rest
    for _ in range(ITERATIONS):
        off = (positions(model, theta, seen) - goal).ravel() / NEAR
        slope = point_slopes(model, theta, seen) @ solve(model, theta, T) / NEAR * scatter
        J, r = np.vstack([slope, np.eye(u.size)]), np.concatenate([off, u / scatter])
        step = np.linalg.lstsq(J, -r, rcond=None)[0]
        step /= max(1.0, float(np.abs(step).max()))
        theta, taken = _settled(body, T, theta, u, scatter * step)
        u = u + taken
        if np.abs(taken / scatter).max() < DONE:
            break
    return theta, T @ u


def positions(model: RodModel, theta: Array, at: Places) -> Array:
    """Points (s,2) [m] of the pose theta (N,) [rad]."""
    q, points = np.zeros((3, theta.size)), np.zeros((at.rod.size, 2))
    pose(model, theta, q)
    points_on(q, at, points)
    return points


def _settled(body: Body, T: Array, theta: Array, u: Array, step: Array) -> tuple[Array, Array]:
    """Pose after as much of the step of u as leads to a stable one, and that much; torques are bends of the hinges."""
    for share in (1.0, 0.5, 0.25, 0.1):
        try:
            return settle(carrying(body, T @ (u + share * step)), theta), share * step
        except LinAlgError:
            continue
    return theta, np.zeros_like(step)
