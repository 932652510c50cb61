"""The static map of the actuator: linear in the angles, theta = rest + K_theta^-1 T_theta u; the tip is a sum.

Paper, "Quasi-Static Feedforward Control". Rest angles other than zero are not in the paper.
"""

from typing import NamedTuple

import numpy as np

from controller.arrays import Array, Pair, Words
from controller.kernels.compiled import kernel
from controller.kernels.model.polygon import Polygon
from controller.kernels.model.rod import RodModel, RodState, sine_cosine


class StaticMap(NamedTuple):
    """The static map, where it may be used, and a grid of its points to start from."""

    L: Array
    """(N,) [m]."""
    rest: Array
    """(N,) [rad]."""
    compliance: Array
    """(N,2) [rad/(N m)]."""
    polygon: Polygon
    epsilon: float
    rcond_min: float
    seeds: Array
    """Admissible torques (n,2) [N m]."""
    seed_tips: Array
    """Their tips (n,2) [m]."""


StaticModel = RodModel | StaticMap
"""What has a static map: L, rest and compliance."""


class Expansion(NamedTuple):
    """Static tip p(u) to second order; suffix j is a derivative with respect to u_j [N m]."""

    x: float
    y: float
    """p(u) [m]."""
    x_1: float
    x_2: float
    y_1: float
    y_2: float
    """S = dp/du [m/(N m)]."""
    x_11: float
    x_12: float
    x_22: float
    y_11: float
    y_12: float
    y_22: float
    """Curvature of p [m/(N m)^2]."""


class Places(NamedTuple):
    """Material points of the backbone, given by arc length, as rod index and distance from that rod's centre."""

    rod: Words
    """(n,) index."""
    offset: Array
    """(n,) along the rod, towards the tip [m]."""


def places(model: RodModel, arc: Array) -> Places:
    """Where the arc lengths `arc` (n,) [m] lie on the rods of `model`; a joint counts to the rod before it."""
    ends = np.cumsum(model.L)
    rod = np.minimum(np.searchsorted(ends, arc - 1e-9 * ends[-1]), model.L.size - 1).astype(np.int64)
    return Places(rod, arc - (ends - model.L + model.arm)[rod])


def at_rest(model: RodModel) -> RodState:
    """The unactuated equilibrium, without motion: straight along +x where nothing bends the body."""
    state = RodState(np.zeros((3, model.L.size)), np.zeros((3, model.L.size)))
    pose(model, model.rest, state.q)
    return state


@kernel
def pose(model: RodModel, theta: Array, out_q: Array) -> None:
    """Centres and angles (3,N) of the chain with the angles theta (N,) [rad].

    phi_H(q) = 0: paper, "Constrained Dynamic Model".
    """
    x = y = 0.0
    for i in range(theta.size):
        s, c = sine_cosine(theta[i])
        out_q[0, i], out_q[1, i], out_q[2, i] = x + model.arm[i] * c, y + model.arm[i] * s, theta[i]
        x += model.L[i] * c
        y += model.L[i] * s


@kernel
def static_tip(model: StaticModel, u1: float, u2: float) -> Pair:
    """Static tip p(u) = sum L_i (cos theta_i, sin theta_i) [m] (paper, "Quasi-Static Feedforward Control": p_model)."""
    x = y = 0.0
    for i in range(model.L.size):
        s, c = sine_cosine(model.rest[i] + model.compliance[i, 0] * u1 + model.compliance[i, 1] * u2)
        x += model.L[i] * c
        y += model.L[i] * s
    return x, y


@kernel
def expand_tip(model: StaticModel, u1: float, u2: float) -> Expansion:
    """Tip, sensitivity and curvature of the static map at u [N m].

    Tip and S: paper, "Quasi-Static Feedforward Control". Curvature is not in the paper: `newton_point` needs it.
    """
    x = y = x_1 = x_2 = y_1 = y_2 = 0.0
    x_11 = x_12 = x_22 = y_11 = y_12 = y_22 = 0.0
    for i in range(model.L.size):
        c1, c2 = model.compliance[i, 0], model.compliance[i, 1]
        s, c = sine_cosine(model.rest[i] + c1 * u1 + c2 * u2)
        dx, dy = model.L[i] * c, model.L[i] * s
        x, y = x + dx, y + dy
        x_1, x_2 = x_1 - dy * c1, x_2 - dy * c2
        y_1, y_2 = y_1 + dx * c1, y_2 + dx * c2
        x_11, x_12, x_22 = x_11 - dx * c1 * c1, x_12 - dx * c1 * c2, x_22 - dx * c2 * c2
        y_11, y_12, y_22 = y_11 - dy * c1 * c1, y_12 - dy * c1 * c2, y_22 - dy * c2 * c2
    return Expansion(x, y, x_1, x_2, y_1, y_2, x_11, x_12, x_22, y_11, y_12, y_22)


@kernel
def sensitivity(model: StaticModel, theta: Array) -> tuple[float, float, float, float]:
    """S = J(theta) K_theta^-1 T_theta [m/(N m)] at any pose theta (N,), by rows: S11, S12, S21, S22.

    Eq. S: paper, "Quasi-Static Feedforward Control".
    """
    S11 = S12 = S21 = S22 = 0.0
    for i in range(theta.size):
        s, c = sine_cosine(theta[i])
        J_x, J_y = -model.L[i] * s, model.L[i] * c
        S11, S12 = S11 + J_x * model.compliance[i, 0], S12 + J_x * model.compliance[i, 1]
        S21, S22 = S21 + J_y * model.compliance[i, 0], S22 + J_y * model.compliance[i, 1]  # Eq. S
    return S11, S12, S21, S22


@kernel
def side_of(model: StaticModel, u1: float, u2: float) -> float:
    """Determinant of the static map's S at u [m^2/(N m)^2]: its sign tells on which side of a fold that pose is.

    Not in the paper, which leaves the folds of the inverse open.
    """
    x_1 = x_2 = y_1 = y_2 = 0.0
    for i in range(model.L.size):
        c1, c2 = model.compliance[i, 0], model.compliance[i, 1]
        s, c = sine_cosine(model.rest[i] + c1 * u1 + c2 * u2)
        dx, dy = model.L[i] * c, model.L[i] * s
        x_1, x_2 = x_1 - dy * c1, x_2 - dy * c2
        y_1, y_2 = y_1 + dx * c1, y_2 + dx * c2
    return x_1 * y_2 - x_2 * y_1


@kernel
def points_on(q: Array, at: Places, out_points: Array) -> None:
    """Positions (n,2) [m] of the material points `at` in the pose q (3,N).

    Not in the paper, whose points are the rods' centres and the tip.
    """
    for j in range(at.rod.size):
        i = at.rod[j]
        s, c = sine_cosine(q[2, i])
        out_points[j, 0] = q[0, i] + at.offset[j] * c
        out_points[j, 1] = q[1, i] + at.offset[j] * s


@kernel
def tip_of(model: RodModel, q: Array) -> Pair:
    """Distal end of the last rod [m] in the pose q (3,N) (paper, "Dynamic observer": p_model)."""
    last = model.L.size - 1
    s, c = sine_cosine(q[2, last])
    beyond = model.L[last] - model.arm[last]
    return q[0, last] + beyond * c, q[1, last] + beyond * s
