"""The same RK4 step with the full matrix of Eq. KKT and a general solver: what its structure saves."""

import numpy as np

from controller.kernels.rod import Array, Load, RodModel, RodState, constraint_residual, free_acceleration, rotations
from controller.realtime.compiled import compiled


@compiled
def kkt_matrix(model: RodModel, a: Array) -> Array:
    """[[M, A^T], [A, 0]] (5N,5N) for the unknowns x (N), y (N), theta (N), -lambda_x (N), -lambda_y (N)."""
    rods = model.m.size
    matrix = np.zeros((5 * rods, 5 * rods))
    for i in range(rods):
        matrix[i, i] = matrix[rods + i, rods + i] = model.m[i]
        matrix[2 * rods + i, 2 * rods + i] = model.I[i]
        for axis in range(2):
            hinge = (3 + axis) * rods + i
            matrix[hinge, axis * rods + i] = 1.0
            matrix[hinge, 2 * rods + i] = -a[axis, i]
            if i > 0:
                matrix[hinge, axis * rods + i - 1] = -1.0
                matrix[hinge, 2 * rods + i - 1] = -a[axis, i - 1]
    matrix[: 3 * rods, 3 * rods :] = matrix[3 * rods :, : 3 * rods].T
    return matrix


@compiled
def dense_acceleration(model: RodModel, q: Array, v: Array, load: Load) -> Array:
    """Accelerations (3,N) from one linear system of 5N unknowns: 3N accelerations and 2N hinge forces."""
    rods = model.m.size
    a, zero, right = np.empty((2, rods)), np.zeros((3, rods)), np.empty((5, rods))
    rotations(q[2], model.L, a)
    free_acceleration(model, q, v, load, right[:3])
    constraint_residual(model, q, v, a, zero, right[3:])
    for i in range(rods):
        right[0, i] *= model.m[i]
        right[1, i] *= model.m[i]
        right[2, i] *= model.I[i]
    solution = np.linalg.solve(kkt_matrix(model, a), right.ravel())
    acceleration: Array = solution[: 3 * rods].reshape(3, rods)  # type: ignore[assignment]
    return acceleration


@compiled
def dense_step(model: RodModel, state: RodState, load: Load, dt: float) -> None:
    """`rk4_step` with the dense solver."""
    q, v = state.q, state.v
    acc_1 = dense_acceleration(model, q, v, load)
    v_2 = v + dt / 2 * acc_1
    acc_2 = dense_acceleration(model, q + dt / 2 * v, v_2, load)
    v_3 = v + dt / 2 * acc_2
    acc_3 = dense_acceleration(model, q + dt / 2 * v_2, v_3, load)
    v_4 = v + dt * acc_3
    acc_4 = dense_acceleration(model, q + dt * v_3, v_4, load)
    q += dt / 6 * (v + 2 * v_2 + 2 * v_3 + v_4)
    v += dt / 6 * (acc_1 + 2 * acc_2 + 2 * acc_3 + acc_4)
