"""The paper's equations as plain dense numpy, written from the text and not from the kernels."""

from dataclasses import dataclass

import numpy as np

from controller.arrays import Array
from controller.kernels.model.rod import RodModel


@dataclass
class Chain:
    """The matrices of "Constrained Dynamic Model" for the coordinates [x_1, y_1, theta_1, ..., theta_N]."""

    model: RodModel

    @property
    def rods(self) -> int:
        return len(self.model.L)

    def mass(self) -> Array:
        return np.diag(np.column_stack([self.model.m, self.model.m, self.model.I]).ravel())

    def of_angles(self, K_theta: Array) -> Array:
        """A matrix on the angles alone, padded with zeros for x and y."""
        full = np.zeros((3 * self.rods, 3 * self.rods))
        full[2::3, 2::3] = K_theta
        return full

    def hinges(self, constant: Array) -> Array:
        """Energy 1/2 sum c_i (theta_i - theta_(i-1))^2 as a matrix, theta_0 = 0."""
        return self.hinge_lines() * constant @ self.hinge_lines().T

    def hinge_lines(self) -> Array:
        """Columns: what a unit torque in each hinge does to the angles."""
        return np.eye(self.rods) - np.eye(self.rods, k=1)

    def stiffness(self) -> Array:
        return self.of_angles(self.hinges(self.model.k))

    def damping(self) -> Array:
        return self.of_angles(self.hinges(self.model.b)) + self.model.alpha * self.mass()

    def phi(self, q: Array) -> Array:
        """Proximal end of rod i minus distal end of rod i-1 (the origin for the first)."""
        p, arm = q.reshape(-1, 3)[:, :2], self.model.arm[:, None]
        along = np.column_stack([np.cos(q[2::3]), np.sin(q[2::3])])
        distal = np.vstack([np.zeros(2), (p + (self.model.L[:, None] - arm) * along)[:-1]])
        return np.asarray((p - arm * along - distal).ravel())

    def jacobian(self, q: Array) -> Array:
        """A = d phi / dq."""
        A = np.zeros((2 * self.rods, 3 * self.rods))
        for i, (theta, arm) in enumerate(zip(q[2::3], self.model.arm, strict=True)):
            across = np.array([-np.sin(theta), np.cos(theta)])
            A[2 * i : 2 * i + 2, 3 * i : 3 * i + 2] = np.eye(2)
            A[2 * i : 2 * i + 2, 3 * i + 2] = -arm * across
            if i + 1 < self.rods:
                A[2 * i + 2 : 2 * i + 4, 3 * i : 3 * i + 2] = -np.eye(2)
                A[2 * i + 2 : 2 * i + 4, 3 * i + 2] = -(self.model.L[i] - arm) * across
        return A

    def jacobian_rate_times_rate(self, q: Array, v: Array) -> Array:
        """A' q' by a central difference: no formula of ours in it."""
        h = 1e-6
        return (self.jacobian(q + h * v) - self.jacobian(q - h * v)) / (2 * h) @ v

    def solve(self, q: Array, v: Array, force: Array) -> tuple[Array, Array]:
        """(q'', lambda) of the paper's index-1 system under the external generalised force."""
        M, A = self.mass(), self.jacobian(q)
        gravity = self.mass() @ np.tile([*self.model.g, 0.0], self.rods)
        springs = self.stiffness() @ q - self.of_angles(self.hinge_lines() * self.model.k)[:, 2::3] @ self.model.bend
        Q = force + gravity - springs - self.damping() @ v
        drift = 2 * self.model.zeta_B * self.model.omega_B * A @ v + self.model.omega_B**2 * self.phi(q)
        right = np.concatenate([Q, -self.jacobian_rate_times_rate(q, v) - drift])
        left = np.block([[M, A.T], [A, np.zeros((2 * self.rods, 2 * self.rods))]])
        solution = np.linalg.solve(left, right)
        return solution[: 3 * self.rods], -solution[3 * self.rods :]
