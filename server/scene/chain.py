"""Ten boxes along a backbone.

They are moved by their poses: viser shows other properties (the points of a line) an update later than poses, and the
observer would seem to lag behind the markers.
"""

import numpy as np
import viser

from controller.arrays import Values
from controller.schema.parameters import SENSORS
from server.scene.colours import Colour


class Chain:
    """Boxes of `width` and `height` [m] that share the `length` [m], with their middle `z` above the plane."""

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
