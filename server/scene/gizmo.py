"""The gizmo: the only thing in viser that a session may drag."""

from typing import Any

import numpy as np
import viser

from controller.schema.modes import Mode
from controller.schema.states import MOVING

GIZMO = "/live/target"
"""Its name in the scene."""

Point = tuple[float, float]


class Gizmo:
    """A handle in the plane; what its drag means for the rig is decided in drag.py."""

    def __init__(self, scene: viser.SceneApi, at: Point) -> None:
        self._controls = scene.add_transform_controls(
            GIZMO,
            scale=0.1,
            active_axes=(True, True, False),
            disable_axes=True,
            disable_rotations=True,
            depth_test=False,
            position=(*at, 0.0),
        )

    def place(self, at: Point, again: bool) -> None:
        """Move it; `again` sends the pose even where the server believes it is there already."""
        if again:
            self._controls.position = (at[0], at[1], 1e-6)
        self._controls.position = (at[0], at[1], 0.0)


def gizmo_point(row: Any) -> Point:
    """Where the gizmo belongs: on the target while following, else where a drag would start, on the tip."""
    mode = int(row["mode"])
    field = "target" if mode in MOVING else "p_ref" if mode == Mode.HOLD else "p_hat"
    x, y = float(row[field][0]), float(row[field][1])
    return (x, y) if np.isfinite(x + y) else (0.0, 0.0)
