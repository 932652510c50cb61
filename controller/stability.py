"""The chain's small motions, and the largest step for which they stay small."""

import math

import numpy as np

from controller.equilibrium import gravity_torque
from controller.kernels.rod import Array, RodModel

STEP_MARGIN = 0.7
"""A step is at most this share of the largest stable one."""


def natural_modes(model: RodModel, theta: Array, K_o: float = 0.0) -> Array:
    """Eigenvalues (2N,) [1/s] of the chain's small motions about the pose theta (N,), held by K_o [N/m] at its end.

    In angles alone: the constraints fix x and y. Eigenvalues are complex; Baumgarte's are not among them.
    """
    J_x, J_y = centre_jacobian(model, theta)
    M = J_x.T * model.m @ J_x + J_y.T * model.m @ J_y + np.diag(model.I)
    hinge = np.eye(model.L.size) - np.eye(model.L.size, k=-1)
    K = hinge.T * model.k @ hinge + K_o * (np.outer(J_x[-1], J_x[-1]) + np.outer(J_y[-1], J_y[-1]))
    B = hinge.T * model.b @ hinge + model.alpha * M
    K -= np.diag(gravity_torque(model, theta)[1])
    zero, one = np.zeros_like(M), np.eye(model.L.size)
    return np.linalg.eigvals(np.block([[zero, one], [-np.linalg.solve(M, K), -np.linalg.solve(M, B)]]))


def centre_jacobian(model: RodModel, theta: Array) -> tuple[Array, Array]:
    """Derivatives of the rods' centres by the angles: rows rods, columns angles (N,N) [m/rad], for x and for y."""
    reach = np.tril(np.tile(model.L, (model.L.size, 1)), -1) + np.diag(model.arm)
    return -reach * np.sin(theta), reach * np.cos(theta)


def largest_step(model: RodModel, u_max: float = 0.0, K_o: float = 0.0) -> float:
    """Largest step [s] for which RK4 damps every mode, at rest and in static poses with torques up to u_max [N m].

    A mode that grows by itself, as a body does that gravity topples, may grow by as much in a step.
    """
    torques = u_max * np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, -1.0), (0.5, 0.5)])
    poses = model.rest + torques @ model.compliance.T
    modes = np.concatenate([natural_modes(model, pose, K_o) for pose in poses])
    drift = np.roots([1.0, 2.0 * model.zeta_B * model.omega_B, model.omega_B**2])
    modes = np.concatenate([modes, drift])
    low, high = 0.0, 3.0 / float(np.abs(modes).max())
    for _ in range(40):
        step = (low + high) / 2
        z = step * modes
        growth = np.abs(1 + z * (1 + z / 2 * (1 + z / 3 * (1 + z / 4))))
        low, high = (step, high) if (growth <= np.maximum(1.0, np.abs(np.exp(z)))).all() else (low, step)
    return low


def stable_substeps(model: RodModel, dt: float, u_max: float = 0.0, K_o: float = 0.0) -> int:
    """Steps that dt [s] must be cut into, with a margin, for RK4 to be stable (see `largest_step`)."""
    return math.ceil(dt / (STEP_MARGIN * largest_step(model, u_max, K_o)))
