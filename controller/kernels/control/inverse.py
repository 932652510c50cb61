"""The static inverse, constrained to the admissible torques, which stays on its branch.

The map u -> tip is many-to-one, folds where det S = 0 and leaves a hole. `refine` is the paper's iteration, kept inside
the admissible polygon and joined by a Newton step where it stalls; `invert` adds the choice of branch.
"""

import math

from controller.arrays import Pair
from controller.kernels.compiled import kernel
from controller.kernels.model.equilibrium import Scratch
from controller.kernels.model.polygon import admissible, lowest_on_edges, nearest_admissible
from controller.kernels.model.sensitivity import Expansion, expand_tip
from controller.kernels.model.statics import StaticMap, static_tip

DISTANCE_DONE = 1e-9
"""A residual below this is solved [m]."""
TOLERANCE = 1e-4
"""A target counts as reached within this [m]."""
MARGIN = 5e-4
"""How much nearer to a target that is out of reach another branch must end to be taken [m]."""
PROMISING, STARTS = 6, 8
"""Grid points at a minimum of the distance that are tried at most, and all that is tried: two starts more, beside u."""
ASIDE = 2.5
"""How far beside u those two are, along the direction in which the tip moves least [spacings of the grid]."""
REFINE_STEPS, SEARCH_STEPS, HALVINGS = 4, 20, 8
STRAIGHT = 0.1
"""Torques that hold an almost straight arm, as a share of u_max."""
STRIDE = 0.25
"""Longest step of one iteration, as a share of u_max: a step must not leap over a fold to another branch."""


@kernel
def gauss_newton(smap: StaticMap, at: Expansion, r1: float, r2: float) -> Pair:
    """The paper's step -S^-1 r [N m], or regularised where rcond(S) (1-norm) is too small; `at` expands the map.

    Eq. FF, Eq. COND: paper, "Quasi-Static Feedforward Control", ill-conditioned below 1e-10. r [m].
    """
    det = at.x_1 * at.y_2 - at.x_2 * at.y_1
    norm = max(abs(at.x_1) + abs(at.y_1), abs(at.x_2) + abs(at.y_2))
    norm_adjugate = max(abs(at.y_2) + abs(at.y_1), abs(at.x_2) + abs(at.x_1))
    if abs(det) >= smap.rcond_min * norm * norm_adjugate and det != 0.0:  # Eq. COND
        return (at.x_2 * r2 - at.y_2 * r1) / det, (at.y_1 * r1 - at.x_1 * r2) / det  # Eq. FF
    H11, H12, H22 = normal_matrix(at, smap.epsilon)
    g1, g2 = at.x_1 * r1 + at.y_1 * r2, at.x_2 * r1 + at.y_2 * r2
    det = H11 * H22 - H12 * H12
    return (H12 * g2 - H22 * g1) / det, (H12 * g1 - H11 * g2) / det


@kernel
def normal_matrix(at: Expansion, epsilon: float) -> tuple[float, float, float]:
    """S^T S + epsilon I: entries 11, 12, 22 (paper, "Quasi-Static Feedforward Control")."""
    H11 = at.x_1 * at.x_1 + at.y_1 * at.y_1 + epsilon
    H22 = at.x_2 * at.x_2 + at.y_2 * at.y_2 + epsilon
    return H11, at.x_1 * at.x_2 + at.y_1 * at.y_2, H22


@kernel
def gauss_newton_point(smap: StaticMap, at: Expansion, u: Pair, r: Pair) -> Pair:
    """Where the paper's step leads; if that is not admissible, the lowest point of its model on the polygon's edge.

    The step: paper, "Quasi-Static Feedforward Control". Constraining it is not in the paper. u [N m], r [m].
    """
    d1, d2 = gauss_newton(smap, at, r[0], r[1])
    if admissible(smap.polygon, u[0] + d1, u[1] + d2):
        return u[0] + d1, u[1] + d2
    g = (at.x_1 * r[0] + at.y_1 * r[1], at.x_2 * r[0] + at.y_2 * r[1])
    return lowest_on_edges(smap.polygon, u, g, normal_matrix(at, smap.epsilon))


@kernel
def newton_point(smap: StaticMap, at: Expansion, u: Pair, r: Pair) -> Pair:
    """Where Newton's step on |r|^2/2 leads, its matrix shifted to be positive; from a saddle, along the way down.

    Gauss-Newton alone stalls on a fold, and for ever where S^T r = 0: the straight pose with the residual along x.
    Not in the paper.
    """
    H11, H12, H22 = normal_matrix(at, 0.0)
    size = H11 + H22 + smap.epsilon
    H11 += r[0] * at.x_11 + r[1] * at.y_11
    H12 += r[0] * at.x_12 + r[1] * at.y_12
    H22 += r[0] * at.x_22 + r[1] * at.y_22
    g1, g2 = at.x_1 * r[0] + at.y_1 * r[1], at.x_2 * r[0] + at.y_2 * r[1]
    lowest = 0.5 * (H11 + H22) - math.hypot(0.5 * (H11 - H22), H12)
    w1, w2 = way_down(H11, H12, H22, lowest, g1, g2)
    shift = max(0.0, 1e-6 * size - lowest) if lowest > 0.0 else 1e-6 * size - 2.0 * lowest
    H11, H22 = H11 + shift, H22 + shift
    det = H11 * H22 - H12 * H12
    v1, v2 = u[0] + (H12 * g2 - H22 * g1) / det, u[1] + (H12 * g1 - H11 * g2) / det
    if lowest < -1e-9 * size:
        stride = STRIDE * smap.polygon.bounds[0]
        return nearest_admissible(smap.polygon, v1 + stride * w1, v2 + stride * w2)
    if admissible(smap.polygon, v1, v2):
        return v1, v2
    return lowest_on_edges(smap.polygon, u, (g1, g2), (H11, H12, H22))


@kernel
def way_down(H11: float, H12: float, H22: float, lowest: float, g1: float, g2: float) -> Pair:
    """Unit eigenvector of (H11 H12; H12 H22) to its eigenvalue `lowest`, turned against the gradient g.

    Not in the paper: part of `newton_point`.
    """
    w1, w2 = H12, lowest - H11
    if abs(lowest - H22) > abs(lowest - H11):
        w1, w2 = lowest - H22, H12
    norm = math.hypot(w1, w2)
    if norm == 0.0:
        w1, w2, norm = 1.0, 0.0, 1.0
    if w1 * g1 + w2 * g2 > 0.0:
        norm = -norm
    return w1 / norm, w2 / norm


@kernel
def backtrack(
    smap: StaticMap, target: Pair, u: Pair, v: Pair, distance: float, scratch: Scratch
) -> tuple[float, float, float]:
    """Halve the step u -> v until the tip comes nearer to `target` than `distance`: u, distance; u itself if never.

    alpha_u: paper, "Quasi-Static Feedforward Control". In place: scratch.
    """
    d1, d2 = v[0] - u[0], v[1] - u[1]
    longest = max(abs(d1), abs(d2))
    share = min(1.0, STRIDE * smap.polygon.bounds[0] / longest) if longest > 0.0 else 0.0
    for _ in range(HALVINGS):
        w1, w2 = u[0] + share * d1, u[1] + share * d2
        x, y = static_tip(smap.statics, w1, w2, scratch)
        nearer = math.hypot(x - target[0], y - target[1])
        if nearer < distance:
            return w1, w2, nearer
        share *= 0.5
    return u[0], u[1], distance


@kernel
def refine(smap: StaticMap, target: Pair, u: Pair, steps: int, scratch: Scratch) -> tuple[float, float, float, bool]:
    """A few iterations of the constrained inverse from u: u, distance |p(u) - target| [m], whether it settled.

    Paper, "Quasi-Static Feedforward Control". The distance never grows; it settles at the target or at a local minimum
    of the distance over the admissible torques. In place: scratch.
    """
    u1, u2 = u
    x, y = static_tip(smap.statics, u1, u2, scratch)
    distance = math.hypot(x - target[0], y - target[1])
    for _ in range(steps):
        if distance < DISTANCE_DONE:
            return u1, u2, distance, True
        at = expand_tip(smap.statics, u1, u2, scratch)
        r = (at.x - target[0], at.y - target[1])
        v1, v2 = gauss_newton_point(smap, at, (u1, u2), r)
        v1, v2, nearer = backtrack(smap, target, (u1, u2), (v1, v2), distance, scratch)
        if nearer > 0.5 * distance:
            n1, n2 = newton_point(smap, at, (u1, u2), r)
            n1, n2, newton = backtrack(smap, target, (u1, u2), (n1, n2), distance, scratch)
            if newton < nearer:
                v1, v2, nearer = n1, n2, newton
        settled = nearer > (1.0 - 1e-7) * distance
        u1, u2, distance = v1, v2, nearer
        if settled:
            return u1, u2, distance, True
    return u1, u2, distance, distance < TOLERANCE


@kernel
def keep_branch(smap: StaticMap, target: Pair, u: Pair, scratch: Scratch) -> tuple[float, float, float, bool]:
    """`refine` from u; near the straight pose, where branches meet, to the one that reaches `target` with less torque.

    There noise, or where the arm came to rest, would choose: from just below straight the way up leads through an S.
    Not in the paper. In place: scratch.
    """
    found = refine(smap, target, u, REFINE_STEPS, scratch)
    if max(abs(u[0]), abs(u[1])) > STRAIGHT * smap.polygon.bounds[0]:
        return found
    other = refine(smap, target, (0.0, 0.0), REFINE_STEPS, scratch)
    less = max(abs(other[0]), abs(other[1])) < max(abs(found[0]), abs(found[1]))
    return other if less and other[2] < TOLERANCE else found


@kernel
def promising_seed(smap: StaticMap, target: Pair, u: Pair, within: float, after: float) -> tuple[int, float]:
    """The grid point that is nearest to `target` among those at a minimum of the distance: place, square of distance.

    Only those farther than `after` (square [m^2]) and nearer than `within` [m] are looked at, and none beside u; place
    -1 if there is none. Each basin of the distance has such a minimum, unless the grid cannot tell it from another one.
    Not in the paper, whose inverse has one start.
    """
    found, nearest = -1, within * within
    for k in range(smap.seeds.shape[0]):
        square = square_from(smap, k, target)
        if after < square < nearest and is_lowest(smap, k, target, square):
            if max(abs(smap.seeds[k, 0] - u[0]), abs(smap.seeds[k, 1] - u[1])) > smap.spacing:
                found, nearest = k, square
    return found, nearest


@kernel
def square_from(smap: StaticMap, k: int, target: Pair) -> float:
    """Square of the distance [m^2] of `target` [m] from the tip at grid point k. Not in the paper."""
    d1, d2 = smap.seed_tips[k, 0] - target[0], smap.seed_tips[k, 1] - target[1]
    return d1 * d1 + d2 * d2


@kernel
def is_lowest(smap: StaticMap, k: int, target: Pair, square: float) -> bool:
    """Whether no neighbour of grid point k is nearer to `target` [m] than it is itself. Not in the paper."""
    for j in range(smap.beside.shape[1]):
        other = smap.beside[k, j]
        if other >= 0 and square_from(smap, other, target) < square:
            return False
    return True


@kernel
def aside(smap: StaticMap, u: Pair, way: float, scratch: Scratch) -> Pair:
    """Admissible torques beside u, where the tip moves least: to one side (`way` 1) or to the other (-1).

    There the map folds: what ends short on an edge may reach from a little further on. Not in the paper.
    In place: scratch.
    """
    H11, H12, H22 = normal_matrix(expand_tip(smap.statics, u[0], u[1], scratch), 0.0)
    lowest = 0.5 * (H11 + H22) - math.hypot(0.5 * (H11 - H22), H12)
    w1, w2 = way_down(H11, H12, H22, lowest, 0.0, 0.0)
    step = way * ASIDE * smap.spacing
    return nearest_admissible(smap.polygon, u[0] + step * w1, u[1] + step * w2)


@kernel
def other_branch(
    smap: StaticMap, target: Pair, now: tuple[float, float, float], margin: float, rank: int, scratch: Scratch
) -> tuple[float, float, float]:
    """The branch that begins at start number `rank` if it ends nearer to `target` than `now` does.

    `now`, which is short of it, and what is returned: u [N m] and the distance that it leaves [m]. It must reach the
    target, or be nearer by `margin` [m]. Not in the paper, whose inverse has one branch. In place: scratch.
    """
    if rank < PROMISING:
        k, after = -1, -1.0
        for _ in range(rank + 1):
            k, after = promising_seed(smap, target, (now[0], now[1]), now[2] + smap.reach, after)
            if k < 0:
                return now
        start = (smap.seeds[k, 0], smap.seeds[k, 1])
    else:
        start = aside(smap, (now[0], now[1]), 1.0 if rank % 2 == 0 else -1.0, scratch)
    v1, v2, other, _ = refine(smap, target, start, SEARCH_STEPS, scratch)
    nearer = other < TOLERANCE or other < now[2] - margin
    return (v1, v2, other) if nearer else now


@kernel
def invert(smap: StaticMap, target: Pair, u: Pair, search: bool, scratch: Scratch) -> tuple[float, float, float]:
    """Static inverse from the present branch's u: new u and the distance it leaves [m].

    If the present branch settled short of the target and `search` is set, the others are tried, the most promising
    first. Not in the paper, whose inverse has one branch. In place: scratch.
    """
    u1, u2, distance, settled = refine(smap, target, u, REFINE_STEPS, scratch)
    now = (u1, u2, distance)
    if settled and search:
        for rank in range(STARTS):
            if now[2] < TOLERANCE:
                break
            now = other_branch(smap, target, now, MARGIN, rank, scratch)
    return now
