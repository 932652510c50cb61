"""The same systems as full matrices for a general solver: what their structure saves."""

import numpy as np

from controller.arrays import Array
from controller.kernels.model.implicit import GAMMA
from controller.kernels.model.integrate import fill_first_stage, fill_stage, finish_step
from controller.kernels.model.rod import (
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
        fill_stage(state, stage, dt if stage == 3 else 0.5 * dt, work)
        dense_accelerate(model, load, work, stage)
    finish_step(work.acc, dt, state)


@compiled
def stage_matrix(model: RodModel, a: Array, g: float) -> Array:
    """[[M + g B + g^2 K, A^T], [A, 0]] (5N,5N) of a stage of `implicit_step`, unknowns as in `kkt_matrix`."""
    rods, heavier = model.m.size, 1.0 + g * model.alpha
    matrix = kkt_matrix(model, a)
    for i in range(3 * rods):
        matrix[i, i] *= heavier
    for i in range(rods):
        row, stiff = 2 * rods + i, g * (model.b[i] + g * model.k[i])
        matrix[row, row] += stiff
        if i > 0:
            matrix[row - 1, row - 1] += stiff
            matrix[row, row - 1] -= stiff
            matrix[row - 1, row] -= stiff
    return matrix


@compiled
def solve_dense_stages(model: RodModel, q: Array, dt: float, count: int) -> float:
    """`count` times what an implicit step of dt [s] solves: its matrix factorised once, for two right-hand sides.

    The rest of the step is left out, in the dense solver's favour. Returns a number of the solution, so that the
    compiler cannot leave it out.
    """
    a, right, total = np.zeros((2, model.m.size)), np.ones((5 * model.m.size, 2)), 0.0
    for _ in range(count):
        rotations(q[2], model.arm, a)
        total += np.linalg.solve(stage_matrix(model, a, GAMMA * dt), right)[-1, 0]
    return total
