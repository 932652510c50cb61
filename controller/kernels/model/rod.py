"""The constrained rod chain in maximal coordinates (Eq. KKT), solved in O(N) by block elimination.

Hinge i joins the proximal end of rod i to the distal end of rod i-1, hinge 0 to the clamp at the origin. Eliminating
q'' leaves (A M^-1 A^T) lambda = r: symmetric positive definite, block tridiagonal with 2x2 blocks. No matrix is formed.

Symbols: a_i = c_i (-sin theta_i, cos theta_i), so c_i (cos theta_i, sin theta_i) = (a_y, -a_x). The arm c_i from the
proximal end of rod i to its centre of mass is L_i/2; the last rod's differs where a load hangs at its free end.
"""

import math

import numpy as np

from controller.arrays import Array
from controller.kernels.compiled import inlined, kernel
from controller.kernels.group import Group
from controller.kernels.model.springs import Springs, make_springs, pull_of

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
Seen = tuple[float, float, float, float, float]
"""What a hinge sees of the chain beyond its neighbour (`eliminate`): entries 11, 12, 22 of D [1/kg], and two of r."""


class RodModel(Group):
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
    """K_theta^-1 T_theta (N,2) at rest [rad/(N m)]: static angles are rest + compliance u where that is linear."""
    stiffening: Array
    """Share of k that |u1| and |u2| add to it, by the pressures that they need (N,2) [1/(N m)]; (0,2) for none."""
    stretching: Array
    """Share of a rod's length that |u1| and |u2| add to it, likewise (N,2) [1/(N m)]; (0,2) for none."""
    m_inv: Array
    """1/m (N,)."""
    I_inv: Array
    """1/I (N,)."""


class RodState(Group):
    """Pose and velocity of every rod; rows x, y [m] of the centre, theta [rad]."""

    q: Array
    """(3,N)."""
    v: Array
    """(3,N)."""


class Load(Group):
    """Generalised forces on the rods: what is held during one step, zeroed and refilled by the caller, and springs."""

    Q_theta: Array
    """Torque on theta_i (N,) [N m]."""
    F: Array
    """Force at the centre of rod i (2,N) [N]."""
    springs: Springs
    """The observer's; a plant has none."""


class Work(Group):
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
    G: Array
    """Factors of the eliminated hinges, see `fold` (4,N)."""
    r: Array
    """Right-hand side, eliminated in place (2,N)."""


def make_work(rods: int) -> Work:
    """Scratch arrays for a chain of `rods`."""
    q, v, acc, a = (np.zeros((4, rows, rods)) for rows in (3, 3, 3, 2))
    free, G, r = (np.zeros((rows, rods)) for rows in (3, 4, 2))
    return Work(q, v, acc, a, np.zeros((4, 2, rods + 1)), free, G, r)


def make_load(rods: int, springs: int = 0) -> Load:
    """No load on a chain of `rods`, and room for `springs`."""
    return Load(np.zeros(rods), np.zeros((2, rods)), make_springs(springs))


@kernel
def under_levels(own: Array, share: Array, level_1: float, level_2: float, out_pressed: Array) -> None:
    """What (N,) of hinges or rods becomes of their `own` under the two pairs' pressures, which add a `share` (N,2).

    Stiffness, lengths and gravity's torques alike. A level is what a pair's pressures would make of torque if both of
    them acted one way [N m]: |u_j| where one chamber of each pair is empty. Not in the paper, where none changes.
    """
    for i in range(own.size):
        out_pressed[i] = own[i] * (1.0 + share[i, 0] * level_1 + share[i, 1] * level_2)


@inlined
def sine_cosine(theta: float) -> tuple[float, float]:
    """(sin, cos) of theta [rad] to 4e-16 for |theta| < 1e4; no branches, so a loop over it uses the vector unit.

    theta = n pi + 2 h with |h| <= pi/4; minimax polynomials of h (fdlibm's), then the double-angle formulas. The C
    library's pair takes half of a rod step. Not in the paper: speed.
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
def rotations(theta: Array, arm: Array, out_a: Array) -> None:
    """Directions of the hinges: a_i = c_i (-sin theta_i, cos theta_i) (2,N) [m].

    They make up A, the Jacobian of phi_H (paper, "Constrained Dynamic Model").
    """
    for i in range(theta.size):
        s, c = sine_cosine(theta[i])
        out_a[0, i] = -arm[i] * s
        out_a[1, i] = arm[i] * c


@inlined
def free_acceleration(model: RodModel, q: Array, v: Array, load: Load, out_free: Array) -> None:
    """M^-1 Q (3,N) [m/s^2, rad/s^2]: springs, dampers, mass damping, gravity and load, without hinge forces.

    Springs and dampers: paper, "Constrained Dynamic Model". alpha M and the hinges' b, for which beta K stands: Eq. RAY
    (paper, "Parameter Estimation"). Gravity and rest bend: not in the paper.
    """
    last, alpha = model.k.size - 1, model.alpha
    for axis in range(2):
        g = model.g[axis]
        for i in range(last + 1):
            out_free[axis, i] = load.F[axis, i] * model.m_inv[i] + g - alpha * v[axis, i]  # Eq. RAY
    inner = model.k[0] * (q[2, 0] - model.bend[0]) + model.b[0] * v[2, 0]
    for i in range(last):
        stretch = q[2, i + 1] - q[2, i] - model.bend[i + 1]
        outer = model.k[i + 1] * stretch + model.b[i + 1] * (v[2, i + 1] - v[2, i])
        out_free[2, i] = (outer - inner + load.Q_theta[i]) * model.I_inv[i] - alpha * v[2, i]  # Eq. RAY
        inner = outer
    out_free[2, last] = (load.Q_theta[last] - inner) * model.I_inv[last] - alpha * v[2, last]  # Eq. RAY


@inlined
def add_springs(model: RodModel, springs: Springs, q: Array, v: Array, a: Array, free: Array) -> None:
    """Add what the virtual springs give to M^-1 Q. Eq. OBS: paper, "Dynamic observer". In place: free (3,N)."""
    for j in range(springs.active[0]):
        i = springs.rod[j]
        f_x, f_y, torque = pull_of(springs, j, model.arm, q, v, a)
        free[0, i] += f_x * model.m_inv[i]
        free[1, i] += f_y * model.m_inv[i]
        free[2, i] += torque * model.I_inv[i]


@inlined
def constraint_residual(model: RodModel, q: Array, v: Array, a: Array, free: Array, out_r: Array) -> None:
    """Right-hand side -A' q' - 2 zeta_B omega_B A q' - omega_B^2 phi - A M^-1 Q (2,N) of the hinge forces [m/s^2].

    Eq. BAUM: paper, "Constrained Dynamic Model", the lower row. phi_i is a difference of two rod ends, so r_i is a
    difference of what each end brings: its free acceleration plus Baumgarte's share of its velocity and position.
    """
    damp = 2.0 * model.zeta_B * model.omega_B
    pull = model.omega_B * model.omega_B
    distal_x = distal_y = 0.0
    for i in range(out_r.shape[1]):
        ax, ay, omega = a[0, i], a[1, i], v[2, i]
        centre_x = free[0, i] + damp * v[0, i] + pull * q[0, i]
        centre_y = free[1, i] + damp * v[1, i] + pull * q[1, i]
        swing = free[2, i] + damp * omega
        stretch = pull - omega * omega
        end_x = swing * ax + stretch * ay
        end_y = swing * ay - stretch * ax
        out_r[0, i] = distal_x - (centre_x - end_x)  # Eq. BAUM
        out_r[1, i] = distal_y - (centre_y - end_y)  # Eq. BAUM
        distal_x = centre_x + end_x
        distal_y = centre_y + end_y


@inlined
def eliminate(model: RodModel, a: Array, r: Array, out_G: Array) -> None:
    """Block elimination of the hinges from both ends towards the middle one; factors (4,N) as `fold` makes them.

    D_i = J_(i-1) + J_i and E_(i-1,i) = J_(i-1) - (2/m_(i-1)) 1, with J_i = (1/m_i) 1 + a_i a_i^T / I_i, how easily a
    force moves the end of rod i. Two independent sweeps fill the gaps that the divisions of one would leave.
    `base` and `tip` are what the next hinge sees of the part already eliminated: that part's block of D, entries 11,
    12, 22, and what it takes from r. The clamp gives nothing, the free end has no hinge. Not in the paper, which only
    says that its matrix is sparse. In place: r (2,N) becomes D^-1 r.
    """
    last, middle = r.shape[1] - 1, r.shape[1] // 2
    base = (0.0, 0.0, 0.0, 0.0, 0.0)
    J11, J12, J22 = mobility(model, a, last)
    tip = (J11, J12, J22, 0.0, 0.0)
    for i in range(last - middle):
        base = fold(model, a, (i, i), base, r, out_G)
        tip = fold(model, a, (last - i, last - i - 1), tip, r, out_G)
    if 2 * middle > last:
        base = fold(model, a, (middle - 1, middle - 1), base, r, out_G)
    D11, D12, D22 = base[0] + tip[0], base[1] + tip[1], base[2] + tip[2]
    x, y = r[0, middle] - base[3] - tip[3], r[1, middle] - base[4] - tip[4]
    det_inv = 1.0 / (D11 * D22 - D12 * D12)
    r[0, middle], r[1, middle] = det_inv * (D22 * x - D12 * y), det_inv * (D11 * y - D12 * x)


@inlined
def mobility(model: RodModel, a: Array, rod: int) -> tuple[float, float, float]:
    """How easily a force moves the end of `rod`: J, entries 11, 12, 22 [1/kg]. Not in the paper: see `eliminate`."""
    w, across, a_x, a_y = model.m_inv[rod], model.I_inv[rod], a[0, rod], a[1, rod]
    return w + a_x * a_x * across, a_x * a_y * across, w + a_y * a_y * across


@inlined
def fold(model: RodModel, a: Array, at: tuple[int, int], seen: Seen, r: Array, out_G: Array) -> Seen:
    """Eliminate hinge at[0] and return what its neighbour sees across rod at[1] (see `eliminate`).

    Puts D^-1 E, entries 11, 12, 21, 22, into column at[0] of out_G (4,N). Nothing but one factor waits for the
    division. Not in the paper: see `eliminate`. In place: r, as `eliminate` says.
    """
    i, rod = at
    J11, J12, J22 = mobility(model, a, rod)
    E11, E12, E22 = J11 - 2.0 * model.m_inv[rod], J12, J22 - 2.0 * model.m_inv[rod]
    D11, D12, D22, x, y = seen[0] + J11, seen[1] + J12, seen[2] + J22, r[0, i] - seen[3], r[1, i] - seen[4]
    det_inv = 1.0 / (D11 * D22 - D12 * D12)
    G11, G12 = D22 * E11 - D12 * E12, D22 * E12 - D12 * E22
    G21, G22 = D11 * E12 - D12 * E11, D11 * E22 - D12 * E12
    s_x, s_y = D22 * x - D12 * y, D11 * y - D12 * x
    out_G[0, i], out_G[1, i], out_G[2, i], out_G[3, i] = det_inv * G11, det_inv * G12, det_inv * G21, det_inv * G22
    r[0, i], r[1, i] = det_inv * s_x, det_inv * s_y
    J11 -= det_inv * (E11 * G11 + E12 * G21)
    J12 -= det_inv * (E11 * G12 + E12 * G22)
    J22 -= det_inv * (E12 * G12 + E22 * G22)
    return J11, J12, J22, det_inv * (E11 * s_x + E12 * s_y), det_inv * (E12 * s_x + E22 * s_y)


@inlined
def substitute(G: Array, r: Array, out_lam: Array) -> None:
    """Hinge forces lambda (2,N) [N] from the middle outwards: each from its neighbour's.

    Not in the paper: the way back of `eliminate`.
    """
    last, middle = r.shape[1] - 1, r.shape[1] // 2
    base = tip = (r[0, middle], r[1, middle])
    out_lam[0, middle], out_lam[1, middle] = base
    for i in range(1, last - middle + 1):
        base = unfold(G, r, middle - i, base)
        tip = unfold(G, r, middle + i, tip)
        out_lam[0, middle - i], out_lam[1, middle - i] = base
        out_lam[0, middle + i], out_lam[1, middle + i] = tip
    if 2 * middle > last:
        out_lam[0, 0], out_lam[1, 0] = unfold(G, r, 0, base)


@inlined
def unfold(G: Array, r: Array, i: int, neighbour: tuple[float, float]) -> tuple[float, float]:
    """lambda_i = D_i^-1 r_i - D_i^-1 E lambda_neighbour [N]. Not in the paper: see `substitute`."""
    x, y = neighbour
    return r[0, i] - (G[0, i] * x + G[1, i] * y), r[1, i] - (G[2, i] * x + G[3, i] * y)


@inlined
def apply_hinges(model: RodModel, a: Array, free: Array, lam: Array, out_acc: Array) -> None:
    """Accelerations q'' = M^-1 (Q + A^T lambda) (3,N): paper, "Constrained Dynamic Model", the upper row.

    `out_acc` may be `free`.
    """
    for i in range(free.shape[1]):
        sum_x, sum_y = lam[0, i] + lam[0, i + 1], lam[1, i] + lam[1, i + 1]
        out_acc[0, i] = free[0, i] + (lam[0, i] - lam[0, i + 1]) * model.m_inv[i]
        out_acc[1, i] = free[1, i] + (lam[1, i] - lam[1, i + 1]) * model.m_inv[i]
        out_acc[2, i] = free[2, i] - (a[0, i] * sum_x + a[1, i] * sum_y) * model.I_inv[i]


@inlined
def accelerate(model: RodModel, load: Load, stage: int, work: Work) -> None:
    """Acceleration work.acc[stage] (3,N) and hinge forces work.lam[stage] at work.q[stage], work.v[stage].

    Eq. KKT: paper, "Constrained Dynamic Model". A state that is not finite gives accelerations that are not finite.
    In place: work.
    """
    q, v, a, lam = work.q[stage], work.v[stage], work.a[stage], work.lam[stage]
    rotations(q[2], model.arm, a)
    free_acceleration(model, q, v, load, work.free)
    add_springs(model, load.springs, q, v, a, work.free)
    constraint_residual(model, q, v, a, work.free, work.r)
    eliminate(model, a, work.r, work.G)
    substitute(work.G, work.r, lam)
    apply_hinges(model, a, work.free, lam, work.acc[stage])  # Eq. KKT
