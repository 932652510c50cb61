"""From torques to the four chambers, and the model of their delay: dead time, then a first-order lag."""

import math

from controller.arrays import Array
from controller.kernels.compiled import flushed, kernel


@kernel
def chamber_pressures(u: Array, pascal_per_torque: Array, out_p_set: Array) -> None:
    """Setpoints (4,) [Pa] of the chambers (u1+, u1-, u2+, u2-) for u (2,) [N m], by their slopes (4,).

    Linear: u_j > 0 pressurises one chamber of the pair, u_j < 0 the other (paper, "Controller Architecture").
    """
    for chamber in range(out_p_set.shape[0]):
        out_p_set[chamber] = chamber_pressure(u, pascal_per_torque, chamber)


@kernel
def chamber_pressure(u: Array, pascal_per_torque: Array, chamber: int) -> float:
    """Pressure [Pa] of one of them for u (2,) [N m] (paper, "Controller Architecture")."""
    j = chamber // 2
    return max(u[j] if chamber == 2 * j else -u[j], 0.0) * pascal_per_torque[chamber] + 0.0


@kernel
def first_order_lag(p: float, p_set: float, tau: float, dt: float) -> float:
    """p after dt [s] of dp/dt = (p_set - p) / tau, exactly. Eq. LAG: paper, "Dynamic observer", tau = 50 ms."""
    return flushed(p_set + (p - p_set) * math.exp(-dt / tau))  # Eq. LAG


@kernel
def delay(u1: float, u2: float, head: int, ring: Array) -> tuple[float, float, int]:
    """u of d calls before and the new head, after u [N m] is put in at `head` of `ring` (d+1,2).

    Eq. DEAD: paper, "Dynamic observer", a pure delay of some 50 ms. In place: ring.
    """
    ring[head, 0] = u1
    ring[head, 1] = u2
    oldest = head + 1
    if oldest == ring.shape[0]:
        oldest = 0
    return ring[oldest, 0], ring[oldest, 1], oldest  # Eq. DEAD
