"""The measured markers: large where the observer uses them, with an arrow of the residual; small and pale elsewhere."""

from typing import Any

import numpy as np
import viser

from controller.arrays import Values
from controller.schema.parameters import BACKBONE_POINTS, SENSORS
from server.scene.colours import MEASURED

RESIDUAL_GAIN = 5.0
"""Residual arrows are drawn this many times as long as they are, as in the plan view."""
ARROW_MIN_M = 1e-3
"""Shorter arrows are not drawn, nor smaller changes of one sent [m]."""
USED, UNUSED = (MEASURED, 0.005), ((175, 222, 204), 0.0028)
"""Colour and radius [m] of the balls."""
STEP = (BACKBONE_POINTS - 1) // SENSORS


class Markers:
    """One ball a rod, `z` above the plane [m]."""

    def __init__(self, scene: viser.SceneApi, name: str, z: float) -> None:
        self._z = z
        self._balls = [
            scene.add_icosphere(f"{name}{i + 1}", UNUSED[1], UNUSED[0], subdivisions=2, visible=False)
            for i in range(SENSORS)
        ]
        self._arrows = [_arrow(scene, f"{name}{i + 1}_residual") for i in range(SENSORS)]

    def place(self, row: Any) -> None:
        """Show markers (10,2) [m] and residuals of one telemetry row; nan: the marker is not seen."""
        sensed, backbone = int(row["sensed"]), np.asarray(row["backbone"], np.float64)
        for i, at in enumerate(np.asarray(row["markers"], np.float64)):
            used = bool(sensed >> i & 1)
            self._place_ball(self._balls[i], at, used)
            self._place_arrow(self._arrows[i], backbone[STEP * (i + 1)], at, used)

    def _place_ball(self, ball: Any, at: Values, used: bool) -> None:
        ball.visible = bool(np.isfinite(at).all())
        if ball.visible:
            ball.position = (at[0], at[1], self._z)
        color, radius = USED if used else UNUSED
        if ball.radius != radius:
            ball.color, ball.radius = color, radius

    def _place_arrow(self, arrow: Any, observed: Values, measured: Values, used: bool) -> None:
        """Its foot is a pose and in step with the body; its end may come an update later."""
        end = RESIDUAL_GAIN * (measured - observed)
        arrow.visible = used and bool(np.linalg.norm(end) >= ARROW_MIN_M)
        if not arrow.visible:
            return
        arrow.position = (observed[0], observed[1], self._z)
        if np.linalg.norm(end - arrow.points[0, 1, :2]) >= ARROW_MIN_M:
            arrow.points = _from_foot(*end)


def _arrow(scene: viser.SceneApi, name: str) -> Any:
    foot, radius = _from_foot(0.01, 0.0), 0.0008
    return scene.add_arrows(
        name, foot, MEASURED, shaft_radius=radius, head_radius=3 * radius, head_length=6 * radius, visible=False
    )


def _from_foot(x: float, y: float) -> np.ndarray[Any, np.dtype[np.float32]]:
    return np.array([[[0.0, 0.0, 0.0], [x, y, 0.0]]], np.float32)
