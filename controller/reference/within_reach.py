"""Which part of a path is within reach, and the nearest path that is."""

from typing import NamedTuple

import numpy as np

from controller.actuator import Actuator
from controller.errors import ParameterError
from controller.kernels.inverse import MARGIN_NEARER, REFINE_STEPS, TOLERANCE, StaticMap, refine
from controller.kernels.rod import Array
from controller.parameters import ControllerParameters
from controller.reference.approach import EVERY, NEAR_SEEDS, SETTLE_STEPS
from controller.reference.path_file import Samples
from controller.reference.reach import static_tips

FAR = 3.0
"""A point further from the base than so many lengths is in other units."""
DT = ControllerParameters().dt
"""Period of a path's rows [s]."""
JUST = 1e-9
"""Rounding of times [s]."""


class Projected(NamedTuple):
    """The part of a path that is within reach, and the nearest reachable points for the rest."""

    p: Array
    """(n, 2) [m], the path's own points where they can be reached."""
    distance: Array
    """(n,) [m] from the path; 0 where it is within reach."""


def require_near(samples: Samples, p: Array, actuator: Actuator, smap: StaticMap) -> None:
    """ParameterError at the first of p (n, 2) [m] that is too far off to be meant."""
    far = np.flatnonzero(np.linalg.norm(p, axis=1) > FAR * actuator.length)
    if far.size:
        row = int(far[0])
        raise ParameterError(
            f"{place(samples, row * DT)}: {out_of_reach(p[row], nearest(smap, p[row])[1], actuator)}; "
            "are x and y in m? Columns in mm are named x_mm, y_mm"
        )


def require_reach(samples: Samples, path: Projected, p: Array, actuator: Actuator) -> None:
    """ParameterError at the first of p (n, 2) [m] that is out of reach."""
    out = np.flatnonzero(path.distance)
    if out.size:
        row = int(out[0])
        raise ParameterError(
            f"{place(samples, row * DT)}: {out_of_reach(p[row], path.distance[row], actuator)}; "
            f"{100 * out.size / len(p):.3g} % of the path is, by up to {1e3 * path.distance.max():.3g} mm "
            "(--project follows the nearest points within reach)"
        )


def out_of_reach(p: Array, distance: float, actuator: Actuator) -> str:
    """What is wrong with p (2,) [m]."""
    return f"({p[0]:.6g}, {p[1]:.6g}) m is {1e3 * distance:.3g} mm out of the reach of {actuator.name}"


def place(samples: Samples, t: float) -> str:
    """File, time, and line of the last sample before `t` [s] after the first one."""
    at = int(np.searchsorted(samples.t, samples.t[0] + t + JUST, "right")) - 1
    return f"{samples.path}, line {samples.lines[at]} (t = {samples.t[0] + t:.6g} s)"


def projected(smap: StaticMap, p: Array) -> Projected:
    """The path p (n, 2) [m] in the reach: on one branch of the static inverse as long as another is no better.

    Another is looked for and taken as the tick does (`kernels.inverse.invert`), but among all seeds.
    """
    found, distances = p.copy(), np.zeros(len(p))
    (u1, u2), _ = nearest(smap, p[0])
    for i, (x, y) in enumerate(p):
        u1, u2, distance, _ = refine(smap, (x, y), (u1, u2), REFINE_STEPS)
        if distance < TOLERANCE:
            continue
        (v1, v2), other = nearest(smap, p[i]) if i % EVERY == 0 or not distances[i - 1] else ((u1, u2), distance)
        if other < TOLERANCE or other < distance - MARGIN_NEARER:
            u1, u2, distance = v1, v2, other
        if distance >= TOLERANCE:
            found[i], distances[i] = static_tips(smap, np.array([u1, u2])), distance
    return Projected(found, distances)


def nearest(smap: StaticMap, p: Array) -> tuple[tuple[float, float], float]:
    """Torques [N m] of the point of the reach that is nearest to p (2,) [m], and its distance [m]."""
    best, u = np.inf, (0.0, 0.0)
    for k in np.argsort(np.linalg.norm(smap.seed_tips - p, axis=1))[:NEAR_SEEDS]:
        u1, u2, distance, _ = refine(smap, (p[0], p[1]), (smap.seeds[k, 0], smap.seeds[k, 1]), SETTLE_STEPS)
        if distance < best:
            best, u = distance, (u1, u2)
    return u, float(best)
