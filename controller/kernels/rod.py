"""The constrained rod chain in maximal coordinates (Eq. KKT), solved in O(N) by block elimination.

Hinge i joins the proximal end of rod i to the distal end of rod i-1, hinge 0 to the clamp at the origin. Eliminating
q'' leaves (A M^-1 A^T) lambda = r: symmetric positive definite, block tridiagonal with 2x2 blocks. No matrix is formed.

Symbols: a_i = c_i (-sin theta_i, cos theta_i), so c_i (cos theta_i, sin theta_i) = (a_y, -a_x). The arm c_i from the
proximal end of rod i to its centre of mass is L_i/2; the last rod's differs where a load hangs at its free end.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from controller.kernels.compiled import inlined

Array = np.ndarray[Any, np.dtype[np.float64]]

ROUND = 6755399441055744.0
"""1.5 * 2^52: adding and then subtracting it rounds a double to the nearest integer."""
PI_HIGH, PI_LOW = 3.1415926218032837, 3.178650954705639e-08
"""pi in two parts: n PI_HIGH is exact for every bend a chain can have."""
SIN = (
    -1.66666666666666324348e-01,
    8.33333333332248946124e-03,
    -1.98412698298579493134e-04,
    2.75573137070700676789e-06,
    -2.50507602534068634195e-08,
    1.58969099521155010221e-10,
)
COS = (
    4.16666666666666019037e-02,
    -1.38888888888741095749e-03,
    2.48015872894767294178e-05,
    -2.75573143513906633035e-07,
    2.08757232129817482790e-09,
    -1.13596475577881948265e-11,
)
"""Coefficients of h^3.. and h^4.. in fdlibm's sine and cosine on [-pi/4, pi/4]."""


class RodModel(NamedTuple):
    """A chain of N rods, base first. SI units."""

    m: Array
    """Mass (N,) [kg]."""
    I: Array  # noqa: E741
    """Moment of inertia about the centre of mass (N,) [kg m^2]."""
    L: Array
    """Length (N,) [m]."""
    arm: Array
    """From the proximal end to the centre of mass (N,) [m]."""
    k: Array
    """Stiffness of hinge i, between rods i-1 and i (N,) [N m/rad]."""
    b: Array
    """Damping of hinge i (N,) [N m s/rad]."""
    bend: Array
    """Bend of hinge i at which its spring carries nothing (N,) [rad]."""
    alpha: float
    """Mass-proportional damping [1/s]."""
    g: Array
    """Gravity (2,) [m/s^2]."""
    omega_B: float
    """Baumgarte frequency [rad/s]."""
    zeta_B: float
    """Baumgarte damping ratio [1]."""
    T_theta: Array
    """Torque map (N,2): Q_theta = T_theta u [1]."""
    rest: Array
    """Angles of the unactuated equilibrium (N,) [rad]: zero without gravity and rest bend."""
    compliance: Array
    """K_theta^-1 T_theta (N,2): static angles are rest + compliance u [rad/(N m)]."""
    m_inv: Array
    """1/m (N,)."""
    I_inv: Array
    """1/I (N,)."""


class RodState(NamedTuple):
    """Pose and velocity of every rod; rows x, y [m] of the centre, theta [rad]."""

    q: Array
    """(3,N)."""
    v: Array
    """(3,N)."""


class Load(NamedTuple):
    """Generalised forces on the rods, held during one step; zeroed and refilled by the caller."""

    Q_theta: Array
    """Torque on theta_i (N,) [N m]."""
    F: Array
    """Force at the centre of rod i (2,N) [N]."""


class Work(NamedTuple):
    """Scratch of one step. Rows of the leading axis of length 4 are the stages of RK4, kept for the energy ledger."""

    q: Array
    """(4,3,N)."""
    v: Array
    """(4,3,N)."""
    acc: Array
    """q'' (4,3,N)."""
    a: Array
    """a_i (4,2,N)."""
    lam: Array
    """Hinge forces (4,2,N+1) [N]; the last column, beyond the free end, stays zero."""
    free: Array
    """Acceleration that each rod would have without hinges (3,N)."""
    D_inv: Array
    """Inverse of the eliminated diagonal blocks, entries 11, 12, 22 (3,N)."""
    r: Array
    """Eliminated right-hand side (2,N)."""


def make_work(rods: int) -> Work:
    """Scratch arrays for a chain of `rods`."""
    stages = [np.zeros((4, rows, rods)) for rows in (3, 3, 3, 2)]
    return Work(*stages, np.zeros((4, 2, rods + 1)), np.zeros((3, rods)), np.zeros((3, rods)), np.zeros((2, rods)))


def make_load(rods: int) -> Load:
    """No load on a chain of `rods`."""
    return Load(np.zeros(rods), np.zeros((2, rods)))


@inlined
def sine_cosine(theta):
    """(sin, cos) of theta [rad] to 4e-16 for |theta| < 1e4; no branches, so a loop over it uses the vector unit.

    theta = n pi + 2 h with |h| <= pi/4; minimax polynomials of h (fdlibm's), then the double-angle formulas. The C
    library's pair takes half of a rod step.
    """
    n = (theta * (1.0 / math.pi) + ROUND) - ROUND
    h = 0.5 * ((theta - n * PI_HIGH) - n * PI_LOW)
    odd = n - 2.0 * ((0.5 * n + ROUND) - ROUND)
    sign = 1.0 - 2.0 * odd * odd
    z = h * h
    s = h + h * z * (SIN[0] + z * (SIN[1] + z * (SIN[2] + z * (SIN[3] + z * (SIN[4] + z * SIN[5])))))
    c = 1.0 - 0.5 * z + z * z * (COS[0] + z * (COS[1] + z * (COS[2] + z * (COS[3] + z * (COS[4] + z * COS[5])))))
    return sign * (2.0 * s * c), sign * (1.0 - 2.0 * s * s)


@inlined
def rotations(theta, arm, a):
    """a_i = c_i (-sin theta_i, cos theta_i) (2,N) [m] into `a`."""
    for i in range(theta.size):
        s, c = sine_cosine(theta[i])
        a[0, i] = -arm[i] * s
        a[1, i] = arm[i] * c


@inlined
def free_acceleration(model, q, v, load, free):
    """M^-1 Q (3,N): springs and dampers of the hinges, mass damping, gravity and load, without hinge forces."""
    last = model.k.size - 1
    inner = model.k[0] * (q[2, 0] - model.bend[0]) + model.b[0] * v[2, 0]
    for i in range(last + 1):
        outer = 0.0
        if i < last:
            stretch = q[2, i + 1] - q[2, i] - model.bend[i + 1]
            outer = model.k[i + 1] * stretch + model.b[i + 1] * (v[2, i + 1] - v[2, i])
        free[0, i] = load.F[0, i] * model.m_inv[i] + model.g[0] - model.alpha * v[0, i]
        free[1, i] = load.F[1, i] * model.m_inv[i] + model.g[1] - model.alpha * v[1, i]
        free[2, i] = (outer - inner + load.Q_theta[i]) * model.I_inv[i] - model.alpha * v[2, i]
        inner = outer


@inlined
def constraint_residual(model, q, v, a, free, r):
    """Right-hand side -A' q' - 2 zeta_B omega_B A q' - omega_B^2 phi - A M^-1 Q (2,N) of the hinge forces.

    phi_i is a difference of two rod ends, so r_i is a difference of what each end brings: its free acceleration plus
    Baumgarte's share of its velocity and position.
    """
    damp = 2.0 * model.zeta_B * model.omega_B
    pull = model.omega_B * model.omega_B
    distal_x = distal_y = 0.0
    for i in range(r.shape[1]):
        ax, ay, omega = a[0, i], a[1, i], v[2, i]
        centre_x = free[0, i] + damp * v[0, i] + pull * q[0, i]
        centre_y = free[1, i] + damp * v[1, i] + pull * q[1, i]
        swing = free[2, i] + damp * omega
        stretch = pull - omega * omega
        end_x = swing * ax + stretch * ay
        end_y = swing * ay - stretch * ax
        r[0, i] = distal_x - (centre_x - end_x)
        r[1, i] = distal_y - (centre_y - end_y)
        distal_x = centre_x + end_x
        distal_y = centre_y + end_y


@inlined
def eliminate(model, a, D_inv, r):
    """Forward sweep of block Thomas: D_i <- D_i - E D_(i-1)^-1 E, r_i <- r_i - E D_(i-1)^-1 r_(i-1), in place.

    D_i = J_i + J_(i-1), E_(i-1,i) = J_(i-1) - (2/m_(i-1)) 1 with J_i = (1/m_i) 1 + a_i a_i^T / I_i.
    """
    J11 = J12 = J22 = E11 = E12 = E22 = 0.0
    i11 = i12 = i22 = rx = ry = 0.0
    for i in range(r.shape[1]):
        G11, G12 = E11 * i11 + E12 * i12, E11 * i12 + E12 * i22
        G21, G22 = E12 * i11 + E22 * i12, E12 * i12 + E22 * i22
        D11 = J11 - (G11 * E11 + G12 * E12)
        D12 = J12 - (G11 * E12 + G12 * E22)
        D22 = J22 - (G21 * E12 + G22 * E22)
        rx, ry = r[0, i] - (G11 * rx + G12 * ry), r[1, i] - (G21 * rx + G22 * ry)
        w = model.m_inv[i]
        E12 = J12 = a[0, i] * a[1, i] * model.I_inv[i]
        J11, J22 = w + a[0, i] * a[0, i] * model.I_inv[i], w + a[1, i] * a[1, i] * model.I_inv[i]
        E11, E22 = J11 - 2.0 * w, J22 - 2.0 * w
        D11, D12, D22 = D11 + J11, D12 + J12, D22 + J22
        det_inv = 1.0 / (D11 * D22 - D12 * D12)
        i11, i12, i22 = D22 * det_inv, -D12 * det_inv, D11 * det_inv
        D_inv[0, i], D_inv[1, i], D_inv[2, i] = i11, i12, i22
        r[0, i], r[1, i] = rx, ry


@inlined
def substitute(model, a, D_inv, r, lam):
    """Backward sweep: hinge forces lambda_i = D_i^-1 (r_i - E_(i,i+1) lambda_(i+1)) (2,N) into `lam`."""
    x = y = 0.0
    for i in range(r.shape[1] - 1, -1, -1):
        swing = (a[0, i] * x + a[1, i] * y) * model.I_inv[i]
        rx = r[0, i] + model.m_inv[i] * x - a[0, i] * swing
        ry = r[1, i] + model.m_inv[i] * y - a[1, i] * swing
        x = D_inv[0, i] * rx + D_inv[1, i] * ry
        y = D_inv[1, i] * rx + D_inv[2, i] * ry
        lam[0, i], lam[1, i] = x, y


@inlined
def apply_hinges(model, a, free, lam, acc):
    """Accelerations q'' = M^-1 (Q + A^T lambda) (3,N) into `acc`."""
    for i in range(free.shape[1]):
        sum_x, sum_y = lam[0, i] + lam[0, i + 1], lam[1, i] + lam[1, i + 1]
        acc[0, i] = free[0, i] + (lam[0, i] - lam[0, i + 1]) * model.m_inv[i]
        acc[1, i] = free[1, i] + (lam[1, i] - lam[1, i + 1]) * model.m_inv[i]
        acc[2, i] = free[2, i] - (a[0, i] * sum_x + a[1, i] * sum_y) * model.I_inv[i]


@inlined
def accelerate(model, load, work, stage):
    """Acceleration work.acc[stage] (3,N) and hinge forces work.lam[stage] at work.q[stage], work.v[stage].

    Paper, "Constrained Dynamic Model". A state that is not finite gives accelerations that are not finite.
    """
    q, v, a, lam = work.q[stage], work.v[stage], work.a[stage], work.lam[stage]
    rotations(q[2], model.arm, a)
    free_acceleration(model, q, v, load, work.free)
    constraint_residual(model, q, v, a, work.free, work.r)
    eliminate(model, a, work.D_inv, work.r)
    substitute(model, a, work.D_inv, work.r, lam)
    apply_hinges(model, a, work.free, lam, work.acc[stage])  # Eq. KKT
