"""The same RK4 step with the full matrix of Eq. KKT and a general solver: what its structure saves."""

import numpy as np

from controller.kernels.integrate import fill_first_stage, fill_stage, finish_step
from controller.kernels.rod import (
    Array,
    Load,
    RodModel,
    RodState,
    Work,
    constraint_residual,
    free_acceleration,
    rotations,
)
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
            row, x, theta = (3 + axis) * rods + i, axis * rods + i, 2 * rods + i
            matrix[row, x] = matrix[x, row] = 1.0
            matrix[row, theta] = matrix[theta, row] = -a[axis, i]
            if i > 0:
                matrix[row, x - 1] = matrix[x - 1, row] = -1.0
                matrix[row, theta - 1] = matrix[theta - 1, row] = -a[axis, i - 1]
    return matrix


@compiled
def dense_accelerate(model: RodModel, load: Load, work: Work, stage: int) -> None:
    """`accelerate` from one linear system of 5N unknowns: 3N accelerations and 2N hinge forces."""
    rods = model.m.size
    q, v, a = work.q[stage], work.v[stage], work.a[stage]
    right = np.zeros(5 * rods)
    force, drift = right[: 3 * rods].reshape((3, rods)), right[3 * rods :].reshape((2, rods))
    rotations(q[2], model.arm, a)
    constraint_residual(model, q, v, a, force, drift)  # without free accelerations: they are unknowns here
    free_acceleration(model, q, v, load, force)
    for i in range(rods):
        force[0, i] *= model.m[i]
        force[1, i] *= model.m[i]
        force[2, i] *= model.I[i]
    solution = np.linalg.solve(kkt_matrix(model, a), right)
    for row in range(3):
        for i in range(rods):
            work.acc[stage, row, i] = solution[row * rods + i]


@compiled
def dense_step(model: RodModel, state: RodState, load: Load, dt: float, work: Work) -> None:
    """`rk4_step` with the dense solver."""
    fill_first_stage(state, work)
    dense_accelerate(model, load, work, 0)
    for stage in range(1, 4):
        fill_stage(state, work, stage, dt if stage == 3 else 0.5 * dt)
        dense_accelerate(model, load, work, stage)
    finish_step(state, work.acc, dt)
