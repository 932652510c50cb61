"""The admissible torques: a convex polygon, the box |u_j| <= u_max cut by the bend limit |c . u| <= bend_max and more.

Paper, "Hardware setup": saturation keeps to the operating range and prevents self-collision; its bounds are ours.
"""

from controller.arrays import Array, Pair
from controller.kernels.compiled import kernel
from controller.kernels.group import Group


class Polygon(Group):
    """{u : normals u <= bounds}, with zero inside, and its corners."""

    normals: Array
    """Of its m sides (m,2), the first that of u_1 <= u_max."""
    bounds: Array
    """(m,) > 0; the first is u_max [N m]."""
    corners: Array
    """(n,2) counter-clockwise [N m]."""


@kernel
def admissible(polygon: Polygon, u1: float, u2: float) -> bool:
    """Whether u [N m] is in the polygon; its edge belongs to it, within rounding.

    Paper, "Hardware setup": the operating range.
    """
    for k in range(polygon.bounds.size):
        if not polygon.normals[k, 0] * u1 + polygon.normals[k, 1] * u2 <= polygon.bounds[k] * (1.0 + 1e-12):
            return False
    return True


@kernel
def lowest_on_edges(polygon: Polygon, u: Pair, g: Pair, H: tuple[float, float, float]) -> Pair:
    """Where g.(v - u) + (v - u).H (v - u)/2 is lowest on the polygon's edges; H = (H11, H12, H22) positive definite.

    Not in the paper, which saturates after its inverse: ours looks for the best of what is admissible.
    """
    lowest, v1, v2 = 1e300, u[0], u[1]
    count = polygon.corners.shape[0]
    for k in range(count):
        a1, a2 = polygon.corners[k]
        b1, b2 = polygon.corners[(k + 1) % count]
        t1, t2 = b1 - a1, b2 - a2
        slope = t1 * (g[0] + H[0] * (a1 - u[0]) + H[1] * (a2 - u[1]))
        slope += t2 * (g[1] + H[1] * (a1 - u[0]) + H[2] * (a2 - u[1]))
        share = min(1.0, max(0.0, -slope / (H[0] * t1 * t1 + 2.0 * H[1] * t1 * t2 + H[2] * t2 * t2)))
        w1, w2 = a1 + share * t1 - u[0], a2 + share * t2 - u[1]
        value = g[0] * w1 + g[1] * w2 + 0.5 * (H[0] * w1 * w1 + 2.0 * H[1] * w1 * w2 + H[2] * w2 * w2)
        if value < lowest:
            lowest, v1, v2 = value, u[0] + w1, u[1] + w2
    return v1, v2


@kernel
def nearest_admissible(polygon: Polygon, u1: float, u2: float) -> Pair:
    """The admissible point nearest to u [N m]; nan stays nan. Not in the paper, which does not say how it saturates."""
    return nearest_by(polygon, (u1, u2), (1.0, 0.0, 1.0))


@kernel
def nearest_by(polygon: Polygon, u: Pair, H: tuple[float, float, float]) -> Pair:
    """The same, nearest by (v - u).H (v - u), H as in `lowest_on_edges`. Not in the paper: see `nearest_admissible`."""
    if admissible(polygon, u[0], u[1]) or u[0] != u[0] or u[1] != u[1]:
        return u
    return lowest_on_edges(polygon, u, (0.0, 0.0), H)
