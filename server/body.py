"""What viser shows of one actuator: rods as bodies, markers, reference, target, the gizmo, the ground."""

from typing import Any

import numpy as np
import viser

from controller.actuator import Actuator
from controller.modes import Mode
from controller.parameters import SENSORS
from server.channels import Rows
from server.colours import BASE, DANGER, MEASURED, OBSERVER, REFERENCE, TARGET

GIZMO = "/target"
"""Scene name of the gizmo: the only thing in viser that a session may drag."""

Point = tuple[float, float]


class Body:
    """Everything in the scene that belongs to one actuator."""

    def __init__(self, server: viser.ViserServer, actuator: Actuator, light: bool) -> None:
        scene, h = server.scene, actuator.height
        rod = (actuator.length / SENSORS, actuator.width, h)
        self._rods = [scene.add_box(f"/arm/rod{i + 1}", dimensions=rod, color=OBSERVER) for i in range(SENSORS)]
        block = (0.4 * actuator.width, 1.6 * actuator.width, 1.2 * h)
        self._base = scene.add_box("/base", dimensions=block, color=BASE, position=(-block[0] / 2, 0.0, 0.0))
        self._above = h / 2 + 0.003
        self._markers = [scene.add_icosphere(f"/marker/{i + 1}", 0.005, color=MEASURED) for i in range(SENSORS)]
        self._reference = scene.add_icosphere("/reference", 0.003, color=REFERENCE)
        self._target = scene.add_icosphere("/wish", 0.002, color=TARGET)
        self._gizmo = scene.add_transform_controls(
            GIZMO,
            scale=0.1,
            active_axes=(True, True, False),
            disable_axes=True,
            disable_rotations=True,
            depth_test=False,
            position=(actuator.length, 0.0, 0.0),
        )
        self._others = [] if light else [_grid(server, actuator)]

    def remove(self) -> None:
        """Take everything out of the scene."""
        balls = (*self._markers, self._reference, self._target)
        for item in (*self._rods, self._base, *balls, self._gizmo, *self._others):
            item.remove()

    def update(self, row: Any) -> None:
        """Show one telemetry row."""
        backbone = np.asarray(row["backbone"], np.float64)
        if np.isfinite(backbone).all():
            self._place_rods(backbone)
        stopped = int(row["mode"]) in (Mode.FAULT, Mode.E_STOP)
        self._base.color = DANGER if stopped else BASE
        sensed = int(row["sensed"])
        for i, (ball, at) in enumerate(zip(self._markers, row["markers"], strict=True)):
            self._place(ball, at, shown=bool(sensed >> i & 1) or i == SENSORS - 1)
        moving = int(row["mode"]) in (Mode.HOLD, Mode.FOLLOW, Mode.TRACK)
        self._place(self._reference, row["p_ref"], moving)
        self._place(self._target, row["target"], int(row["mode"]) == Mode.FOLLOW)

    def place_gizmo(self, at: Point, again: bool) -> None:
        """Move the gizmo; `again` sends the pose even where the server believes it is there already."""
        if again:
            self._gizmo.position = (at[0], at[1], 1e-6)
        self._gizmo.position = (at[0], at[1], 0.0)

    def _place_rods(self, backbone: Rows) -> None:
        """Rod i lies between backbone samples 2i and 2i + 2, its middle at 2i + 1."""
        along = np.diff(backbone[::2], axis=0)
        half = np.arctan2(along[:, 1], along[:, 0]) / 2
        for box, (x, y), c, s in zip(self._rods, backbone[1::2], np.cos(half), np.sin(half), strict=True):
            box.position = (x, y, 0.0)
            box.wxyz = (c, 0.0, 0.0, s)

    def _place(self, ball: Any, at: Rows, shown: bool) -> None:
        ball.visible = shown = shown and bool(np.isfinite(at).all())
        if shown:
            ball.position = (at[0], at[1], self._above)


def gizmo_point(row: Any) -> Point:
    """Where the gizmo belongs: on the target while following, else where a drag would start, on the tip."""
    mode = int(row["mode"])
    field = "target" if mode in (Mode.FOLLOW, Mode.TRACK) else "p_ref" if mode == Mode.HOLD else "p_hat"
    x, y = float(row[field][0]), float(row[field][1])
    return (x, y) if np.isfinite(x + y) else (0.0, 0.0)


def _grid(server: viser.ViserServer, actuator: Actuator) -> Any:
    return server.scene.add_grid(
        "/ground",
        width=8 * actuator.length,
        height=8 * actuator.length,
        cell_size=0.05,
        section_size=0.25,
        cell_color=(60, 60, 60),
        section_color=(90, 90, 90),
        position=(0.0, 0.0, -actuator.height / 2 - 1e-3),
    )
