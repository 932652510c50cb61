"""Static tests: pressures and where the markers came to rest, from a table, and what a model says to the same."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from controller.arrays import Array
from controller.assembly.equilibrium import body_of, settle
from controller.assembly.rod import build_rod
from controller.errors import DataError, ParameterError
from controller.kernels.model.equilibrium import Body
from controller.kernels.model.rod import RodModel
from controller.research.identification.tables import MeasuredTable, points_in
from controller.schema.actuator import Actuator

FINE = 40
"""Rods of the model that is fitted, at least: a real body is continuous, and 10 rods read 2 % too much into P2."""

STAGES = 20
"""Torques are brought up in this many steps where gravity keeps Newton's iteration from converging at once."""

STRETCH = 1.2
"""A marker farther from the base than this many lengths is a mistake of units or of the frame, not a pose."""


@dataclass(frozen=True)
class Poses:
    """n poses of m markers in the actuator's frame (base at the origin, +x along the backbone at the clamp)."""

    path: Path
    lines: Array
    """Line of the file (n,)."""
    chambers: Array
    """Pressures of u1+, u1-, u2+, u2- (n,4) [Pa]: where the file has differences alone, one of each pair is empty."""
    by_chamber: bool
    """Whether the file has all four pressures."""
    points: Array
    """(n,m,2) [m]."""
    arcs: Array
    """Arc length of each marker (m,) [m], without pressure."""

    @property
    def pressure(self) -> Array:
        """Differential pressure of both pairs (n,2) [Pa]; positive bends towards +y."""
        return np.asarray(self.chambers[:, ::2] - self.chambers[:, 1::2])

    @property
    def level(self) -> Array:
        """Sum of the pressures of each pair (n,2) [Pa]."""
        return np.asarray(self.chambers[:, ::2] + self.chambers[:, 1::2])


def is_static(table: MeasuredTable) -> bool:
    """True for a table of pressures and markers."""
    return "p1" in table.columns


def read_poses(table: MeasuredTable, actuator: Actuator) -> Poses:
    """The poses in `table`; DataError names the column or the line that cannot be used."""
    points = points_in(table, "xy")
    known = {f"{axis}{i + 1}" for axis in "xy" for i in range(points.shape[1])} | {"p1", "p2", "p3", "p4"}
    if strange := [name for name in table.columns if name not in known]:
        raise DataError(f"{table.path}: column {strange[0]} is unknown in a static test (p1, p2[, p3, p4], x1, y1, ..)")
    chambers, by_chamber = _pressures(table)
    arcs = marker_arcs(actuator, points.shape[1])
    poses = Poses(table.path, table.lines, chambers, by_chamber, _in_frame(points, actuator), arcs)
    _check(poses, actuator)
    return poses


def _pressures(table: MeasuredTable) -> tuple[Array, bool]:
    """Pressures (n,4) [Pa] of the chambers, and whether the file has them, or differences; DataError for p < 0."""
    if "p3" not in table.columns and "p4" not in table.columns:
        one, other = table.need("p1"), table.need("p2")
        return np.maximum(np.stack([one, -one, other, -other], axis=-1), 0.0), False
    return np.stack([table.need(f"p{chamber}") for chamber in range(1, 5)], axis=-1), True


def marker_arcs(actuator: Actuator, markers: int) -> Array:
    """Arc lengths (m,) [m] from the actuator's `tracking`; without it m markers sit at L/m, 2L/m, .. and the tip."""
    if actuator.tracking is None:
        return actuator.length * np.arange(1, markers + 1) / markers
    arcs = actuator.tracking.arcs
    if len(arcs) != markers:
        raise DataError(f"the data have {markers} markers, tracking.arcs of actuator {actuator.name} has {len(arcs)}")
    return np.array(arcs)


def fine(actuator: Actuator) -> int:
    """Rods of the model that is fitted."""
    return max(FINE, actuator.table_rods)


def predict(actuator: Actuator, poses: Poses) -> Array:
    """Markers (n,m,2) [m] where the static model of `fine(actuator)` rods puts them under the same pressures."""
    model = build_rod(actuator, fine(actuator))
    backbone = backbones(model, *torques(actuator, poses.chambers))
    ends = np.concatenate([[0.0], np.cumsum(model.L)])
    return np.array([[[np.interp(s, ends, axis) for axis in pose] for s in poses.arcs] for pose in backbone])


def torques(actuator: Actuator, pressures: Array) -> tuple[Array, Array]:
    """Torques u (n,2) of the chambers' `pressures` (n,4) [Pa], and their levels (n,2), as of `under_levels` [N m]."""
    each = pressures / actuator.chamber_slopes
    return each[:, ::2] - each[:, 1::2], each[:, ::2] + each[:, 1::2]


def backbones(model: RodModel, u: Array, level: Array) -> Array:
    """Joints and tip (n,2,N+1) [m] of the static poses under u (n,2) [N m], at the levels `level` (n,2)."""
    joint_torque = np.cumsum(model.T_theta[::-1], axis=0)[::-1] @ u.T
    stiffer, longer = (
        1.0 + share @ level.T if share.size else np.ones(joint_torque.shape)
        for share in (model.stiffening, model.stretching)
    )
    k = model.k[:, None] * stiffer
    bends = model.bend[:, None] + joint_torque / k
    body, theta = body_of(model), np.cumsum(bends, axis=0)
    if model.g.any():
        bodies = [body._replace(k=k[:, n].copy(), weight=body.weight * longer[:, n]) for n in range(len(u))]
        theta = np.stack([_loaded(one, model, bends[:, n].copy()) for n, one in enumerate(bodies)], axis=1)
    steps = model.L[:, None] * longer * np.stack([np.cos(theta), np.sin(theta)])
    joints = np.concatenate([np.zeros((2, 1, len(u))), np.cumsum(steps, axis=1)], axis=1)
    return np.moveaxis(joints, -1, 0)


def _loaded(body: Body, model: RodModel, bend: Array) -> Array:
    """Angles (N,) of `model`, as stiff as `body`, with the rest bend moved to `bend` (N,), as torques do.

    At once, or where that fails step by step; ParameterError where both do.
    """
    for stages in (1, STAGES):
        theta = model.rest
        try:
            for share in np.linspace(0.0, 1.0, stages + 1)[1:]:
                theta = settle(body._replace(bend=body.bend + share * (bend - body.bend)), theta)
            return theta
        except np.linalg.LinAlgError:
            continue
    gravity = tuple(model.g.tolist())
    raise ParameterError(f"gravity = {gravity} m/s^2: the body has no stable pose under these pressures")


def _in_frame(points: Array, actuator: Actuator) -> Array:
    """Points of the file in the actuator's frame, if `tracking` gives the base and axis of a plane."""
    tracking = actuator.tracking
    if tracking is None or len(tracking.base) != 2:
        return points
    axis = np.array(tracking.axis) / np.linalg.norm(tracking.axis)
    turn = np.array([[axis[0], axis[1]], [-axis[1], axis[0]]])
    return np.asarray((points - np.array(tracking.base)) @ turn.T)


def _check(poses: Poses, actuator: Actuator) -> None:
    if not poses.pressure.any():
        raise DataError(f"{poses.path}: every pressure is 0, so nothing bends and no stiffness follows")
    far = np.linalg.norm(poses.points, axis=-1) > STRETCH * actuator.length
    if far.any():
        row, marker = np.argwhere(far)[0]
        x, y = poses.points[row, marker]
        raise DataError(
            f"{poses.path}, line {poses.lines[row]:.0f}: marker {marker + 1} at ({x:.4g}, {y:.4g}) m is farther from "
            f"the base than {STRETCH} x length = {STRETCH * actuator.length:.4g} m"
        )
