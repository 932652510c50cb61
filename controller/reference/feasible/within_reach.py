"""Which part of a path is within reach, and the nearest path that is."""

import math
from typing import NamedTuple

import numpy as np

from controller.arrays import Array
from controller.assembly.statics import scratch_for
from controller.errors import ParameterError
from controller.kernels.control.along import invert_along
from controller.kernels.control.inverse import REFINE_STEPS, TOLERANCE, invert
from controller.kernels.model.statics import StaticMap
from controller.reference.feasible.approach import EVERY, solutions
from controller.reference.feasible.reach import static_tips
from controller.reference.path_file import Samples
from controller.schema.actuator import Actuator
from controller.schema.parameters import DT

MARGIN_NEARER = 30e-3
"""How much nearer another branch must come to a path that it does not reach: on the way to it the path is left [m]."""
FAR = 3.0
"""A point further from the base than this many lengths is in other units."""
SEARCH_M = 1e-3
"""Out of reach another branch is looked for once in so much of the path [m], or at every this many rows."""
NEAREST_CALLS = 20
"""Most steps of the inverse to the nearest point: each tries all branches."""
JUST = 1e-9
"""Rounding of times [s]."""


class Carried(NamedTuple):
    """A path as the static inverse carries it from one pose on."""

    u: Array
    """(n, 2) torques that hold the points [N m]."""
    p: Array
    """(n, 2) [m], the path's own points where they are within reach, else the nearest."""
    distance: Array
    """(n,) [m] from the path; 0 where it is within reach."""
    changes: tuple[int, ...]
    """Rows at which the branch ends, and another one goes on."""


def require_near(samples: Samples, actuator: Actuator) -> None:
    """ParameterError at the first sample that is too far off to be meant."""
    far = np.flatnonzero(np.hypot(*samples.p.T) > FAR * actuator.length)
    if far.size:
        x, y = samples.p[far[0]]
        raise ParameterError(
            f"{samples.path}, line {samples.lines[far[0]]}: ({x:.6g}, {y:.6g}) m is more than {FAR:g} lengths of "
            f"{actuator.name} ({actuator.length:g} m) from its base; are x and y in m? "
            "Columns in mm are named x_mm, y_mm"
        )


def require_reach(samples: Samples, path: Carried, p: Array, actuator: Actuator) -> None:
    """ParameterError at the first of p (n, 2) [m] that is out of reach."""
    out = np.flatnonzero(path.distance)
    if out.size:
        (x, y), distance = p[out[0]], 1e3 * path.distance[out[0]]
        raise ParameterError(
            f"{place_in_file(samples, out[0] * DT)}: ({x:.6g}, {y:.6g}) m is {distance:.3g} mm out of the reach of "
            f"{actuator.name}; {100 * out.size / len(p):.3g} % of the path is, by up to "
            f"{1e3 * path.distance.max():.3g} mm (--project follows the nearest points within reach)"
        )


def place_in_file(samples: Samples, t: float) -> str:
    """File, line and time of the path `t` [s] after its first sample."""
    at = int(np.searchsorted(samples.t, samples.t[0] + t + JUST, "right")) - 1
    line = f"line {samples.lines[at]}"
    if at + 1 < len(samples.t) and samples.t[at] < samples.t[0] + t - JUST:
        line = f"between lines {samples.lines[at]} and {samples.lines[at + 1]}"
    return f"{samples.path}, {line} (t = {samples.t[0] + t:.6g} s)"


def projected(smap: StaticMap, p: Array) -> Carried:
    """The path p (n, 2) [m] in the reach, on the branch of the static inverse that carries it furthest.

    Of equals the one of the least torque at p[0], as in the library; from u = 0 for a path that begins at rest.
    """
    best = None
    for u in [np.zeros(2)] if is_rest(smap, p[0]) else solutions(smap, p[0]) or [np.array(nearest(smap, p[0])[0])]:
        path = carried(smap, p, u)
        if not path.changes:
            return path
        if best is None or path.changes[0] > best.changes[0]:
            best = path
    assert best is not None
    return best


def is_rest(smap: StaticMap, p: Array) -> bool:
    """Whether p (2,) [m] is the tip at rest."""
    return bool(np.linalg.norm(p - static_tips(smap, np.zeros(2))) < TOLERANCE)


def carried(smap: StaticMap, p: Array, begin: Array) -> Carried:
    """The path p (n, 2) [m] from torques `begin` (2,) [N m] on: on one branch as long as another is no better.

    Another is taken as the tick does (`kernels.control.inverse.invert`), but looked for from rest.
    """
    length = float(np.hypot(*np.diff(p, axis=0).T).sum())
    every = max(EVERY, int(len(p) * SEARCH_M / length)) if length > SEARCH_M else len(p)
    p = np.ascontiguousarray(p)  # one kind of array, so that the kernel is compiled once
    torques, distances, changes = np.empty_like(p), np.zeros(len(p)), []
    row, u, scratch = 0, (begin[0], begin[1]), scratch_for(smap)
    while (row := invert_along(smap, p, row, u, every, REFINE_STEPS, distances, scratch, torques)) < len(p):
        v, other = nearest(smap, p[row])
        if other < TOLERANCE or other < distances[row] - MARGIN_NEARER:
            torques[row], distances[row] = v, other
            changes.append(row)
        u, row = tuple(torques[row]), row + 1
    out = distances >= TOLERANCE
    found = p.copy()
    found[out] = static_tips(smap, torques[out])
    return Carried(torques, found, np.where(out, distances, 0.0), tuple(changes))


def nearest(smap: StaticMap, p: Array) -> tuple[tuple[float, float], float]:
    """Torques [N m] of the point of the reach that is nearest to p (2,) [m], and its distance [m]."""
    u, scratch, before, distance = (0.0, 0.0), scratch_for(smap), math.inf, math.inf
    for _ in range(NEAREST_CALLS):
        u1, u2, distance = invert(smap, (p[0], p[1]), u, True, scratch)
        u = (u1, u2)
        if distance < TOLERANCE or distance == before:
            break
        before = distance
    return u, distance
