"""From torques to the four chambers, and the model of their delay: dead time, then a first-order lag."""

import math

from controller.kernels.compiled import kernel
from controller.kernels.denormal import settled


@kernel
def chamber_pressures(u, pascal_per_torque, p_set):
    """Setpoints (4,) [Pa] of the chambers (u1+, u1-, u2+, u2-) for u (2,) [N m], into `p_set`.

    Linear: u_j > 0 pressurises one chamber of the pair, u_j < 0 the other (paper, "Controller Architecture").
    """
    for chamber in range(p_set.shape[0]):
        p_set[chamber] = chamber_pressure(u, pascal_per_torque, chamber)


@kernel
def chamber_pressure(u, pascal_per_torque, chamber):
    """Pressure [Pa] of one of them for u (2,) [N m]."""
    j = chamber // 2
    return max(u[j] if chamber == 2 * j else -u[j], 0.0) * pascal_per_torque[j] + 0.0


@kernel
def first_order_lag(p, p_set, tau, dt):
    """P after dt [s] of dp/dt = (p_set - p) / tau, exactly (paper, "Dynamic observer": 50 ms)."""
    return settled(p_set + (p - p_set) * math.exp(-dt / tau))


@kernel
def delay(ring, head, u1, u2):
    """Put u in at `head` of `ring` (d+1,2); returns the u of d calls before and the new head."""
    ring[head, 0] = u1
    ring[head, 1] = u2
    oldest = head + 1
    if oldest == ring.shape[0]:
        oldest = 0
    return ring[oldest, 0], ring[oldest, 1], oldest
