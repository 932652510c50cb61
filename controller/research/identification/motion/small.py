"""Small motions of the chain about its rest, in angles."""

import numpy as np

from controller.arrays import Array
from controller.assembly.equilibrium import gravity_torque
from controller.assembly.stability import centre_jacobian
from controller.kernels.model.rod import RodModel


def rest_matrices(model: RodModel) -> tuple[Array, Array, Array]:
    """Inertia [kg m^2], the hinges' stiffness and gravity's [N m/rad] (N,N each) at rest."""
    J_x, J_y = centre_jacobian(model, model.rest)
    M = J_x.T * model.m @ J_x + J_y.T * model.m @ J_y + np.diag(model.I)
    hinge = np.eye(model.L.size) - np.eye(model.L.size, k=-1)
    return M, hinge.T * model.k @ hinge, -np.diag(gravity_torque(model, model.rest)[1])
