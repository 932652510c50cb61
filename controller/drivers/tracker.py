"""Which point that a camera saw belongs to which rod: by its name, else by where the observer expects the rod.

A swap is found because the assignment that is shortest as a whole is taken again in every frame; a ghost, because
it is too far from every rod, or further than the marker itself.
"""

import math
from collections.abc import Callable

import numpy as np

from controller.arrays import Array, Words
from controller.drivers.device import Angles, Sample
from controller.schema.hardware import Frame, MotionCapture
from controller.schema.parameters import SENSORS


def assigned(cost: Array) -> Words:
    """Column of each row (n,) so that the sum of `cost` (n,m), n <= m, finite, is least.

    Shortest augmenting paths (Jonker and Volgenant, 1987), row by row: O(n^2 m).
    """
    n, m = cost.shape
    nearest: Words = cost.argmin(axis=1)
    if len(set(nearest.tolist())) == n:
        return nearest  # as a rule: nothing is cheaper than each row's cheapest
    u, v = np.zeros(n), np.zeros(m)
    row_of, before = np.full(m, -1), np.zeros(m, np.int64)
    for row in range(n):
        column = _augment(cost, row, u, v, row_of, before)
        while True:  # turn the path round
            previous = before[column]
            row_of[column] = row if previous < 0 else row_of[previous]
            if previous < 0:
                break
            column = previous
    found = np.zeros(n, np.int64)
    taken = row_of >= 0
    found[row_of[taken]] = np.flatnonzero(taken)
    return found


def _augment(cost: Array, row: int, u: Array, v: Array, row_of: Words, before: Words) -> int:
    """A free column at the end of the shortest path from `row`. In place: potentials u, v; `before`, the path."""
    shortest, visited = np.full(len(v), np.inf), np.zeros(len(v), bool)
    column, at, gone = -1, row, [row]
    while True:
        reduced = cost[at] - u[at] - v
        better = ~visited & (reduced < shortest)
        shortest[better], before[better] = reduced[better], column
        column = int(np.argmin(np.where(visited, np.inf, shortest)))
        step = shortest[column]
        u[gone] += step
        v[visited] -= step
        shortest[~visited] -= step
        visited[column] = True
        if row_of[column] < 0:
            return column
        at = int(row_of[column])
        gone.append(at)


Expected = Callable[[], Array]
"""Where the observer has its sensors now, (10,2) [m]."""
POINTS_MAX = 1000
"""Of more points in a frame the rest is not looked at: no camera's ghosts may take the time of the whole process."""


class Tracker:
    """Makes markers of a rig's sensors, (10,2) [m] in the plane, of what motion capture saw."""

    def __init__(self, asked: MotionCapture, length: float, expected: Expected) -> None:
        """`length` of the actuator [m]."""
        self._asked, self._length, self._expected = asked, length, expected
        self._axes, self._origin = np.array(asked.frame.axes), np.array(asked.frame.origin)
        self.strangers = 0
        """Points that belonged to no rod: ghosts, reflections, markers of other things."""

    def markers(self, seen: Sample | Angles) -> Array:
        """(10,2) [m]: nan where a rod bears no marker or its marker was not seen."""
        if isinstance(seen, Angles):
            return along(seen, self._length)
        points, found = self._plane(seen), np.full((SENSORS, 2), math.nan)
        free = [rod for rod in self._asked.rods if rod not in self._asked.labels.values()]
        unnamed = []
        for index in range(len(points)):
            name = seen.labels[index] if index < len(seen.labels) else ""
            if rod := self._asked.labels.get(name):
                found[rod - 1] = points[index]
            elif np.isfinite(points[index]).all():
                unnamed.append(index)
        self._assign(points[unnamed], free, found)
        return found

    def _plane(self, seen: Sample) -> Array:
        """Points in the plane (M,2) [m]; nan for those of too little quality."""
        points = np.asarray(seen.points, float)[:POINTS_MAX]
        points = np.where(np.isfinite(points), points, math.nan)
        if points.shape[1] == 2:
            points = np.column_stack((points, np.zeros(len(points))))
        plane: Array = points @ self._axes.T + self._origin
        if seen.quality is not None:
            plane[np.asarray(seen.quality)[: len(plane)] < self._asked.quality_min] = math.nan
        return plane

    def _assign(self, points: Array, free: list[int], found: Array) -> None:
        """Give `points` (K,2) to the rods `free`, so that the sum of squared ways is least. In place: found."""
        if len(points) == 0 or not free:
            self.strangers += len(points)
            return
        expected = self._expected()[np.array(free) - 1]
        way = np.linalg.norm(expected[:, None, :] - points[None, :, :], axis=2)
        # No point at all costs more than all points within the gate: the most markers are found, then the nearest.
        gate, none = self._asked.gate, (len(free) + 1) * self._asked.gate**2
        cost = np.full((len(free), len(points) + len(free)), none)
        cost[:, : len(points)] = np.where(way <= gate, way**2, 2 * none)
        taken = 0
        for row, column in enumerate(assigned(cost)):
            if column < len(points) and way[row, column] <= gate:
                found[free[row] - 1] = points[column]
                taken += 1
        self.strangers += len(points) - taken


def along(seen: Angles, length: float) -> Array:
    """Positions (10,2) [m] of the sensors of a backbone of `length` [m] whose tangent has the angles `seen`.

    The angle runs evenly between two sensors, from 0 at the base, and stays as it is beyond the last one. One that is
    not known is as if it had no sensor. nan everywhere where none is known.
    """
    arcs, angles = np.asarray(seen.arcs, float), np.asarray(seen.angles, float)
    known = np.isfinite(angles) & np.isfinite(arcs)
    if not known.any():
        return np.full((SENSORS, 2), math.nan)
    s = np.linspace(0.0, length, 20 * SENSORS + 1)
    theta = np.interp(s, np.concatenate(([0.0], arcs[known])), np.concatenate(([0.0], angles[known])))
    middle = 0.5 * (theta[1:] + theta[:-1])
    steps = np.diff(s)[:, None] * np.column_stack((np.cos(middle), np.sin(middle)))
    places: Array = np.cumsum(steps, axis=0)[19::20]
    return places


def fitted_frame(seen: Array, plane: Array) -> Frame:
    """The rigid `Frame` that carries points `seen` (M,3) [m] best onto `plane` (M,2) [m]; M >= 3, not on one line.

    Least squares over rotations (Kabsch), and an origin: a frame that also stretched would hide wrong units.
    Raises ValueError for points on one line.
    """
    seen, plane = np.asarray(seen, float), np.asarray(plane, float)
    flat = np.column_stack((plane, np.zeros(len(plane))))
    seen_0, flat_0 = seen.mean(axis=0), flat.mean(axis=0)
    U, size, Vt = np.linalg.svd((seen - seen_0).T @ (flat - flat_0))
    if size[1] < 1e-3 * max(size[0], 1e-12):
        raise ValueError("the points lie on one line: they do not say which way the plane is turned")
    turn = np.diag([1.0, 1.0, np.sign(np.linalg.det(Vt.T @ U.T))])
    R = Vt.T @ turn @ U.T
    origin = flat_0 - R @ seen_0
    return Frame(axes=(tuple(R[0]), tuple(R[1])), origin=(origin[0], origin[1]), measured=True)
