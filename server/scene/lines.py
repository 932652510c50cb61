"""Lines in the scene: paths in dashes, and the trail of the tip. Colour and kind of line go with the role."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import viser

from controller.arrays import Array
from server.scene.colours import DANGER, GHOST, MEASURED, REFERENCE, Colour
from server.scene.messages import Role

DASHES_MAX = 2000
"""Most dashes of one path: a longer path has longer dashes."""


@dataclass(frozen=True)
class Look:
    """Colour, lengths of dash and gap [m], and thickness [m] of a line."""

    color: Colour
    dash: float
    gap: float
    thickness: float


STYLES: dict[Role, Look] = {
    "reference": Look(REFERENCE, 0.007, 0.004, 0.0016),
    "ghost": Look(GHOST, 0.002, 0.003, 0.002),
    "outside": Look(DANGER, 0.007, 0.002, 0.0022),
}
"""What a path looks like in each role."""


class Paths:
    """One path, of any number of lines, for each role, `z` above the plane [m]."""

    def __init__(self, scene: viser.SceneApi, z: float) -> None:
        self._scene, self._z = scene, z
        self._shown: dict[Role, Any] = {}

    def show(self, role: Role, lines: Sequence[Array]) -> None:
        """Show in this role the lines through points (n,2) [m], and nothing else."""
        if (old := self._shown.pop(role, None)) is not None:
            old.remove()
        look = STYLES[role]
        ends = np.concatenate([np.empty((0, 2, 2)), *(dashes(points, look) for points in lines)])
        if len(ends):
            self._shown[role] = _segments(self._scene, f"/path/{role}", raised(ends, self._z), look)


class Trail:
    """Where the measured tip was in the last seconds."""

    def __init__(self, scene: viser.SceneApi, name: str, z: float) -> None:
        self._z, self._last = z, np.empty((0, 2))
        nothing = np.zeros((1, 2, 3))
        self._line = _segments(scene, name, nothing, Look(MEASURED, 0.0, 0.0, 0.0012))
        self._line.visible = False

    def show(self, points: Array) -> None:
        """Join `points` (n,2) [m]."""
        if np.array_equal(points, self._last):
            return
        self._last = points
        self._line.visible = len(points) > 1
        if self._line.visible:
            self._line.points = raised(np.stack([points[:-1], points[1:]], axis=1), self._z)


def dashes(points: Array, look: Look) -> Array:
    """Ends (k,2,2) [m] of the dashes along the line through `points` (n,2): straight, so short beside its curvature."""
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1) if len(points) > 1 else np.zeros(0)
    s = np.concatenate([[0.0], np.cumsum(lengths)])
    if s[-1] <= 0.0:
        return np.empty((0, 2, 2))
    stretch = max(1.0, s[-1] / ((look.dash + look.gap) * DASHES_MAX))
    begin = np.arange(0.0, s[-1], stretch * (look.dash + look.gap))
    ends = np.minimum(np.stack([begin, begin + stretch * look.dash], axis=1), s[-1])
    return np.stack([np.interp(ends, s, points[:, j]) for j in range(2)], axis=-1)


def raised(ends: Array, z: float) -> Array:
    """Ends of lines (k,2,2) in the plane as (k,2,3) at height `z`, as viser takes them."""
    return np.concatenate([ends, np.full((*ends.shape[:2], 1), z)], axis=-1).astype(np.float32)


def _segments(scene: viser.SceneApi, name: str, ends: Array, look: Look) -> Any:
    return scene.add_line_segments(name, ends, look.color, thickness=look.thickness)
