"""What is shown of one actuator in one moment: observer and twin, markers, trail, reference, target."""

from typing import Any

import numpy as np
import viser

from controller.arrays import Array, Values
from controller.schema.actuator import Actuator
from controller.schema.modes import Mode
from controller.schema.parameters import BACKBONE_POINTS, SENSORS
from controller.schema.states import LIVE, MOVING
from server.scene.colours import BASE, DANGER, MEASURED, OBSERVER, REFERENCE, TARGET, TWIN, Colour
from server.scene.lines import Trail

RAISED = 3e-3
"""Height of lines and balls above the body [m]: seen from the top, nothing of them is hidden."""
TARGET_DISC = (20, 20, 20)
"""Under the white ball, so that the target is seen on light ground too."""
TOLERANCES_M = {"backbone": 1e-3, "twin_backbone": 1e-4, "p_ref": 1e-4, "target": 1e-4, "markers": 5e-4}
"""Of an actuator that is not led anywhere, moves up to this are noise: four times that of the twin's, as observed."""
RESIDUAL_GAIN = 5.0
"""Residual arrows are drawn this many times as long as they are, as in the plan view."""
ARROW_MIN_M = 1e-3
"""Shorter arrows are not drawn, nor smaller changes of one sent [m]."""
USED, UNUSED = (MEASURED, 0.005), ((175, 222, 204), 0.0028)
"""Colour and radius [m] of the balls."""
POINTS_APART = (BACKBONE_POINTS - 1) // SENSORS


class Chain:
    """Ten boxes of `width` and `height` [m] that share the `length` [m], with their middle `z` above the plane.

    They are moved by their poses: viser shows other properties (the points of a line) an update later than poses, and
    the observer would seem to lag behind the markers.
    """

    def __init__(
        self, scene: viser.SceneApi, name: str, size: tuple[float, float, float], z: float, color: Colour
    ) -> None:
        length, width, height = size
        box = (length / SENSORS, width, height)
        self._boxes = [scene.add_box(f"{name}{i + 1}", dimensions=box, color=color) for i in range(SENSORS)]
        self._z = z

    def place(self, backbone: Values) -> None:
        """Box i lies between samples 2i and 2i + 2 of `backbone` (21,2) [m], its middle at 2i + 1; nan hides them."""
        known = bool(np.isfinite(backbone).all())
        for box in self._boxes:
            box.visible = known
        if not known:
            return
        along = np.diff(backbone[::2], axis=0)
        half = np.arctan2(along[:, 1], along[:, 0]) / 2
        for box, (x, y), c, s in zip(self._boxes, backbone[1::2], np.cos(half), np.sin(half), strict=True):
            box.position = (x, y, self._z)
            box.wxyz = (c, 0.0, 0.0, s)


class Markers:
    """The measured markers, one ball a rod, `z` above the plane [m].

    Large where the observer uses them, with an arrow of the residual; small and pale elsewhere.
    """

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
            self._place_arrow(self._arrows[i], backbone[POINTS_APART * (i + 1)], at, used)

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


class Body:
    """Everything that one telemetry row says, below the scene node `root`; `hidden` until the first row."""

    def __init__(self, scene: viser.SceneApi, root: str, actuator: Actuator) -> None:
        length, width, height = actuator.length, actuator.width, actuator.height
        self._root = scene.add_frame(root, show_axes=False)
        self._observer = Chain(scene, f"{root}/rod", (length, width, height), 0.0, OBSERVER)
        spine = (length, 0.15 * width, 2e-3)
        self._twin = Chain(scene, f"{root}/twin", spine, height / 2 + 5e-4, TWIN)
        block = (0.4 * width, 1.6 * width, 1.2 * height)
        self._base = scene.add_box(f"{root}/base", dimensions=block, color=BASE, position=(-block[0] / 2, 0.0, 0.0))
        self._above = above(actuator)
        self._markers = Markers(scene, f"{root}/marker", self._above)
        self._trail = Trail(scene, f"{root}/trail", self._above)
        self._reference = scene.add_icosphere(f"{root}/reference", 0.003, color=REFERENCE)
        self._target = scene.add_icosphere(f"{root}/wish", 0.002, color=TARGET)
        self._disc = scene.add_cylinder(f"{root}/disc", 0.0045, 5e-4, color=TARGET_DISC)

    def remove(self) -> None:
        """Take everything out of the scene."""
        self._root.remove()

    def update(self, row: Any, trail: Array) -> None:
        """Show one telemetry row, and where the tip was before, (n,2) [m]."""
        self._observer.place(np.asarray(row["backbone"], np.float64))
        self._twin.place(np.asarray(row["twin_backbone"], np.float64))
        self._markers.place(row)
        self._trail.show(trail)
        mode = int(row["mode"])
        self._base.color = DANGER if mode in (Mode.FAULT, Mode.E_STOP) else BASE
        self._place(self._reference, row["p_ref"], mode in LIVE)
        for part in (self._target, self._disc):
            self._place(part, row["target"], mode == Mode.FOLLOW)

    def _place(self, ball: Any, at: Values, shown: bool) -> None:
        ball.visible = shown = shown and bool(np.isfinite(at).all())
        if shown:
            ball.position = (at[0], at[1], self._above)


def moved(row: Any, shown: Any) -> bool:
    """Whether a telemetry row looks other than the one `shown`, beyond noise unless the reference itself may move."""
    if row["mode"] in MOVING or row["mode"] != shown["mode"] or row["sensed"] != shown["sensed"]:
        return bool(row["tick"] != shown["tick"])
    return any(_apart(row[name], shown[name], tolerance) for name, tolerance in TOLERANCES_M.items())


def _apart(now: Values, before: Values, tolerance: float) -> bool:
    """Further than the tolerance, or nan in only one of them."""
    return bool(((np.abs(now - before) > tolerance) | (np.isnan(now) != np.isnan(before))).any())


def above(actuator: Actuator) -> float:
    """Height at which lines and balls lie [m]."""
    return actuator.height / 2 + RAISED
