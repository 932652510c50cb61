"""The linear system of the implicit step, block tridiagonal, factorised and solved in O(N).

Unknown for each rod are its angular velocity z_i and the impulse lambda_i (2) of its hinge. The rows of x and y are
diagonal in the velocities and are eliminated in closed form: of the 5x5 blocks [x, y, theta, lambda_x, lambda_y] remain
symmetric 3x3 blocks [theta, lambda_x, lambda_y]. With w_i the reciprocal of rod i's mass, damping included:
  row theta_i:    H_i z_i - h_i z_(i-1) - h_(i+1) z_(i+1) + a_i^T (lambda_i + lambda_(i+1)) = r_i1
  rows lambda_i:  a_i z_i + a_(i-1) z_(i-1) - w_i (lambda_i - lambda_(i+1)) + w_(i-1) (lambda_(i-1) - lambda_i) = r_i23
The first row's matrix is positive definite, the others' negative definite: such a matrix is quasi-definite and has
factors without pivoting, whatever the stiffness, the damping and the pose.
"""

from typing import NamedTuple

import numpy as np

from controller.kernels.compiled import inlined
from controller.kernels.rod import Array


class Block(NamedTuple):
    """The matrix (but for a, which the caller holds), its factors, a right-hand side and its solution."""

    H: Array
    """Diagonal of theta's rows (N,) [kg m^2]."""
    h: Array
    """Coupling of rods i-1 and i through hinge i (N,) [kg m^2]."""
    w: Array
    """Diagonal of the eliminated rows of x and y, inverted (N,) [1/kg]."""
    S_inv: Array
    """Inverses of the eliminated diagonal blocks S_i, entries 11, 12, 13, 22, 23, 33 (N,6)."""
    r: Array
    """Right-hand side; `solve` overwrites it (N,3)."""
    z: Array
    """Solution: angular velocities (N,) [rad/s]."""


def make_block(rods: int) -> Block:
    """An empty system for a chain of `rods`."""
    H, h, w, z = (np.zeros(rods) for _ in range(4))
    return Block(H, h, w, np.zeros((rods, 6)), np.zeros((rods, 3)), z)


@inlined
def factorise(block, a):
    """S_i = D_i - U^T S_(i-1)^-1 U, from base to tip, with U = U_(i-1) = [[-h_i, a_(i-1)^T], [0, w_(i-1) 1]]."""
    H, h, w, S_inv = block.H, block.h, block.w, block.S_inv
    t11 = t12 = t13 = t22 = t23 = t33 = before = 0.0
    last = H.size - 1
    for i in range(last + 1):
        ax, ay = a[0, i], a[1, i]
        s11, s12, s13 = H[i] - t11, ax - t12, ay - t13
        s22, s23, s33 = -before - w[i] - t22, -t23, -before - w[i] - t33
        m11, m12, m13 = s22 * s33 - s23 * s23, s13 * s23 - s12 * s33, s12 * s23 - s13 * s22
        det_inv = 1.0 / (s11 * m11 + (s12 * m12 + s13 * m13))
        r11, r12, r13 = m11 * det_inv, m12 * det_inv, m13 * det_inv
        r22, r33 = (s11 * s33 - s13 * s13) * det_inv, (s11 * s22 - s12 * s12) * det_inv
        r23 = (s12 * s13 - s11 * s23) * det_inv
        S_inv[i, 0], S_inv[i, 1], S_inv[i, 2] = r11, r12, r13
        S_inv[i, 3], S_inv[i, 4], S_inv[i, 5] = r22, r23, r33
        before = w[i]
        x1, x2, x3 = r11 * ax + before * r12, r12 * ax + before * r22, r13 * ax + before * r23
        y1, y3 = r11 * ay + before * r13, r13 * ay + before * r33
        couple = h[i + 1] if i < last else 0.0
        t11, t12, t13 = couple * couple * r11, -couple * x1, -couple * y1
        t22, t23, t33 = ax * x1 + before * x2, ay * x1 + before * x3, ay * y1 + before * y3


@inlined
def solve(block, a):
    """block.z from block.r: forward and backward substitution."""
    h, w, S_inv, r, z = block.h, block.w, block.S_inv, block.r, block.z
    last = z.size - 1
    y1 = y2 = y3 = ax = ay = before = 0.0
    for i in range(last + 1):
        r1 = r[i, 0] + h[i] * y1
        r2 = r[i, 1] - (ax * y1 + before * y2)
        r3 = r[i, 2] - (ay * y1 + before * y3)
        r[i, 0], r[i, 1], r[i, 2] = r1, r2, r3
        y1 = S_inv[i, 0] * r1 + (S_inv[i, 1] * r2 + S_inv[i, 2] * r3)
        y2 = S_inv[i, 1] * r1 + (S_inv[i, 3] * r2 + S_inv[i, 4] * r3)
        y3 = S_inv[i, 2] * r1 + (S_inv[i, 4] * r2 + S_inv[i, 5] * r3)
        ax, ay, before = a[0, i], a[1, i], w[i]
    z[last] = y1
    for i in range(last - 1, -1, -1):
        r1 = r[i, 0] + (h[i + 1] * y1 - (a[0, i] * y2 + a[1, i] * y3))
        r2 = r[i, 1] - w[i] * y2
        r3 = r[i, 2] - w[i] * y3
        y1 = S_inv[i, 0] * r1 + (S_inv[i, 1] * r2 + S_inv[i, 2] * r3)
        y2 = S_inv[i, 1] * r1 + (S_inv[i, 3] * r2 + S_inv[i, 4] * r3)
        y3 = S_inv[i, 2] * r1 + (S_inv[i, 4] * r2 + S_inv[i, 5] * r3)
        z[i] = y1
