"""The linear system of the implicit step, block tridiagonal, factorised and solved in O(N).

Unknown for each rod are its angular velocity z_i and the impulse lambda_i (2) of its hinge. The rows of x and y are
diagonal in the velocities and are eliminated in closed form: of the 5x5 blocks [x, y, theta, lambda_x, lambda_y] remain
symmetric 3x3 blocks [theta, lambda_x, lambda_y]. With w_i the reciprocals of rod i's mass, damping included, and p_i
and d_i how a turn moves its proximal and distal end, both a_i but for rods at which springs pull:
  row theta_i:    H_i z_i - h_i z_(i-1) - h_(i+1) z_(i+1) + p_i^T lambda_i + d_i^T lambda_(i+1) = r_i1
  rows lambda_i:  p_i z_i + d_(i-1) z_(i-1) - w_i (lambda_i - lambda_(i+1)) + w_(i-1) (lambda_(i-1) - lambda_i) = r_i23
The first row's matrix is positive definite, the others' negative definite: such a matrix is quasi-definite and has
factors without pivoting, whatever the stiffness, the damping and the pose.
"""

import numpy as np

from controller.arrays import Array
from controller.kernels.compiled import inlined
from controller.kernels.group import Group

Symmetric = tuple[float, float, float, float, float, float]
"""Entries 11, 12, 13, 22, 23, 33 of a symmetric 3x3 block."""
Vector = tuple[float, float, float]
"""Of one block: [theta, lambda_x, lambda_y]."""


class Block(Group):
    """The matrix, its factors, a right-hand side and its solution."""

    H: Array
    """Diagonal of theta's rows (N,) [kg m^2]."""
    h: Array
    """Coupling of rods i-1 and i through hinge i (N+1,) [kg m^2]; 0 beyond the free end."""
    w: Array
    """Inverses of the eliminated rows of x and y, of rod i in w[:, i+1] (2,N+1) [1/kg]; 0 for the clamp."""
    prox: Array
    """p_i (2,N) [m]."""
    dist: Array
    """d_i (2,N) [m]."""
    lean: Array
    """What a rod's motion along x and y takes from its row theta_i, by springs off its centre (2,N) [kg m]."""
    S_inv: Array
    """Inverses of the eliminated diagonal blocks S_i, entries 11, 12, 13, 22, 23, 33 (N,6)."""
    r: Array
    """Right-hand side; `solve_blocks` overwrites it (N,3)."""
    z: Array
    """Solution: angular velocities (N,) [rad/s]."""


def make_block(rods: int) -> Block:
    """An empty system for a chain of `rods`."""
    H, h, w, z = np.zeros(rods), np.zeros(rods + 1), np.zeros((2, rods + 1)), np.zeros(rods)
    prox, dist, lean = np.zeros((3, 2, rods))
    return Block(H, h, w, prox, dist, lean, np.zeros((rods, 6)), np.zeros((rods, 3)), z)


@inlined
def factorise(block: Block) -> None:
    """Inverses of S_i = D_i - (what is eliminated next to it), from both ends to the middle block.

    U_i = [[-h_(i+1), d_i^T], [0, w_i]] couples block i to i+1. Two independent sweeps fill the gaps that the
    divisions of one would leave. Not in the paper: part of `implicit_step`. In place: block.S_inv.
    """
    last, middle = block.z.size - 1, block.z.size // 2
    base = tip = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for i in range(last - middle):
        base = seen_from_tip(i, base, block)
        tip = seen_from_base(last - i, tip, block)
    if 2 * middle > last:
        base = seen_from_tip(middle - 1, base, block)
    seen = base[0] + tip[0], base[1] + tip[1], base[2] + tip[2], base[3] + tip[3], base[4] + tip[4], base[5] + tip[5]
    invert_block(middle, seen, block)


@inlined
def invert_block(i: int, seen: Symmetric, block: Block) -> Symmetric:
    """S_i^-1, where `seen` is what S_i lacks of D_i.

    Not in the paper: part of `implicit_step`. In place: block.S_inv.
    """
    S_inv, p, w = block.S_inv, block.prox, block.w
    s11, s12, s13 = block.H[i] - seen[0], p[0, i] - seen[1], p[1, i] - seen[2]
    s22, s23, s33 = -(w[0, i] + w[0, i + 1]) - seen[3], -seen[4], -(w[1, i] + w[1, i + 1]) - seen[5]
    m11, m12, m13 = s22 * s33 - s23 * s23, s13 * s23 - s12 * s33, s12 * s23 - s13 * s22
    det_inv = 1.0 / (s11 * m11 + (s12 * m12 + s13 * m13))
    r11, r12, r13 = det_inv * m11, det_inv * m12, det_inv * m13
    r22, r33 = det_inv * (s11 * s33 - s13 * s13), det_inv * (s11 * s22 - s12 * s12)
    r23 = det_inv * (s12 * s13 - s11 * s23)
    S_inv[i, 0], S_inv[i, 1], S_inv[i, 2] = r11, r12, r13
    S_inv[i, 3], S_inv[i, 4], S_inv[i, 5] = r22, r23, r33
    return r11, r12, r13, r22, r23, r33


@inlined
def seen_from_tip(i: int, seen: Symmetric, block: Block) -> Symmetric:
    """U_i^T S_i^-1 U_i: what block i+1 sees of the part eliminated up to block i.

    Not in the paper: part of `implicit_step`. In place: block.S_inv.
    """
    r11, r12, r13, r22, r23, r33 = invert_block(i, seen, block)
    d_x, d_y, h = block.dist[0, i], block.dist[1, i], block.h[i + 1]
    w_x, w_y = block.w[0, i + 1], block.w[1, i + 1]
    x1, x2 = r11 * d_x + w_x * r12, r12 * d_x + w_x * r22
    y1, y2, y3 = r11 * d_y + w_y * r13, r12 * d_y + w_y * r23, r13 * d_y + w_y * r33
    return h * h * r11, -h * x1, -h * y1, d_x * x1 + w_x * x2, d_x * y1 + w_x * y2, d_y * y1 + w_y * y3


@inlined
def seen_from_base(i: int, seen: Symmetric, block: Block) -> Symmetric:
    """U_(i-1) S_i^-1 U_(i-1)^T: what block i-1 sees of the part eliminated down to block i.

    Not in the paper: part of `implicit_step`. In place: block.S_inv.
    """
    r11, r12, r13, r22, r23, r33 = invert_block(i, seen, block)
    d_x, d_y, h = block.dist[0, i - 1], block.dist[1, i - 1], block.h[i]
    w_x, w_y = block.w[0, i], block.w[1, i]
    x1 = d_x * r12 + (d_y * r13 - h * r11)
    x2 = d_x * r22 + (d_y * r23 - h * r12)
    x3 = d_x * r23 + (d_y * r33 - h * r13)
    return d_x * x2 + (d_y * x3 - h * x1), w_x * x2, w_y * x3, w_x * w_x * r22, w_x * w_y * r23, w_y * w_y * r33


@inlined
def solve_blocks(block: Block) -> None:
    """block.z from block.r: inwards from both ends, then outwards.

    Not in the paper: part of `implicit_step`. In place: block.r, block.z.
    """
    r, z = block.r, block.z
    last, middle = z.size - 1, z.size // 2
    base = tip = (0.0, 0.0, 0.0)
    for i in range(last - middle):
        r[i, 0], r[i, 1], r[i, 2] = base = without_base(block, i, base)
        r[last - i, 0], r[last - i, 1], r[last - i, 2] = tip = without_tip(block, last - i, tip)
        base, tip = divided(block, i, base), divided(block, last - i, tip)
    if 2 * middle > last:
        r[middle - 1, 0], r[middle - 1, 1], r[middle - 1, 2] = base = without_base(block, middle - 1, base)
        base = divided(block, middle - 1, base)
    r[middle, 0], r[middle, 1], r[middle, 2] = without_base(block, middle, base)
    base = tip = divided(block, middle, without_tip(block, middle, tip))
    z[middle] = base[0]
    for i in range(1, last - middle + 1):
        base = divided(block, middle - i, without_tip(block, middle - i, base))
        tip = divided(block, middle + i, without_base(block, middle + i, tip))
        z[middle - i], z[middle + i] = base[0], tip[0]
    if 2 * middle > last:
        z[0] = divided(block, 0, without_tip(block, 0, base))[0]


@inlined
def without_base(block: Block, i: int, y: Vector) -> Vector:
    """r_i - U_(i-1)^T y: the right-hand side of block i without what y, of block i-1, brings.

    Not in the paper: part of `implicit_step`.
    """
    r, d, w, before = block.r, block.dist, block.w, max(i - 1, 0)
    x1, x2, x3 = y
    return (
        r[i, 0] + block.h[i] * x1,
        r[i, 1] - (d[0, before] * x1 + w[0, i] * x2),
        r[i, 2] - (d[1, before] * x1 + w[1, i] * x3),
    )


@inlined
def without_tip(block: Block, i: int, y: Vector) -> Vector:
    """r_i - U_i y: the right-hand side of block i without what y, of block i+1, brings.

    Not in the paper: part of `implicit_step`.
    """
    r, d, w = block.r, block.dist, block.w
    x1, x2, x3 = y
    return (
        r[i, 0] + (block.h[i + 1] * x1 - (d[0, i] * x2 + d[1, i] * x3)),
        r[i, 1] - w[0, i + 1] * x2,
        r[i, 2] - w[1, i + 1] * x3,
    )


@inlined
def divided(block: Block, i: int, r: Vector) -> Vector:
    """S_i^-1 r. Not in the paper: part of `implicit_step`."""
    S_inv = block.S_inv
    r1, r2, r3 = r
    return (
        S_inv[i, 0] * r1 + (S_inv[i, 1] * r2 + S_inv[i, 2] * r3),
        S_inv[i, 1] * r1 + (S_inv[i, 3] * r2 + S_inv[i, 4] * r3),
        S_inv[i, 2] * r1 + (S_inv[i, 4] * r2 + S_inv[i, 5] * r3),
    )
