"""What is shown of one actuator in one moment: observer and twin, markers, trail, reference, target."""

from typing import Any

import numpy as np
import viser

from controller.arrays import Array, Values
from controller.schema.actuator import Actuator
from controller.schema.modes import Mode
from controller.schema.states import LIVE, MOVING
from server.scene.chain import Chain
from server.scene.colours import BASE, DANGER, OBSERVER, REFERENCE, TARGET, TWIN
from server.scene.lines import Trail
from server.scene.markers import Markers

RAISED = 3e-3
"""Height of lines and balls above the body [m]: seen from the top, nothing of them is hidden."""
TARGET_DISC = (20, 20, 20)
"""Under the white ball, so that the target is seen on light ground too."""
TOLERANCES_M = {"backbone": 1e-3, "twin_backbone": 1e-4, "p_ref": 1e-4, "target": 1e-4, "markers": 5e-4}
"""Of an actuator that is not led anywhere, moves up to this are noise: four times that of the twin's, as observed."""


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
