"""Small motions of the chain about its rest, in angles."""

import numpy as np

from controller.arrays import Array
from controller.build.equilibrium import gravity_torque
from controller.build.stability import centre_jacobian
from controller.kernels.model.rod import RodModel
from controller.kernels.model.statics import Places
from controller.research.identification.motion.hold import slopes


def rest_matrices(model: RodModel) -> tuple[Array, Array, Array]:
    """Inertia [kg m^2], the hinges' stiffness and gravity's [N m/rad] (N,N each) at rest."""
    J_x, J_y = centre_jacobian(model, model.rest)
    M = J_x.T * model.m @ J_x + J_y.T * model.m @ J_y + np.diag(model.I)
    hinge = np.eye(model.L.size) - np.eye(model.L.size, k=-1)
    return M, hinge.T * model.k @ hinge, -np.diag(gravity_torque(model, model.rest)[1])


def step_mobility(model: RodModel, at: Places, dt: float) -> Array:
    """Velocity that a unit impulse across the body at each point (s,) gives it in one implicit step [1/kg].

    The hinges' springs and dampers take part in a step of dt [s] as additional inertia.
    """
    M, K, _ = rest_matrices(model)
    hinge = np.eye(model.L.size) - np.eye(model.L.size, k=-1)
    heavier = (1.0 + dt * model.alpha) * M + dt * hinge.T * model.b @ hinge + dt**2 * K
    across = slopes(model, model.rest, at)[1::2]
    return np.asarray(np.einsum("ij,ji->i", across, np.linalg.solve(heavier, across.T)))
