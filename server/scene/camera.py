"""Where the camera stands in each view; actuator and reach fill it."""

from dataclasses import dataclass
from typing import Any
from urllib.parse import urlencode

import numpy as np

from server.scene.messages import View

Vector = tuple[float, float, float]
PARALLEL = 1e-6


@dataclass(frozen=True)
class Camera:
    """Position, point looked at [m], up direction, vertical field of view [rad]."""

    position: Vector
    look_at: Vector
    up: Vector
    fov: float = 0.42

    @property
    def query(self) -> str:
        """Query string that makes viser's page start here."""
        names = {"Position": self.position, "LookAt": self.look_at, "Up": self.up}
        words = {f"initialCamera{name}": ",".join(f"{x:.4f}" for x in value) for name, value in names.items()}
        return urlencode({**words, "initialCameraFov": f"{self.fov:.4f}"}, safe=",")

    def aim(self, camera: Any) -> None:
        """Move one client's camera here; viser refuses every moment in which it would look along its up direction."""
        across = np.cross(camera.look_at - camera.position, np.subtract(self.look_at, self.position))
        if np.linalg.norm(across) > PARALLEL:
            camera.up_direction = across / np.linalg.norm(across)
        camera.fov, camera.position, camera.look_at = self.fov, self.position, self.look_at
        camera.up_direction = self.up


def camera_of(view: View, length: float) -> Camera:
    """The camera of `view` for an actuator of `length` [m]."""
    middle = (0.4 * length, 0.0, 0.0)
    if view == "top":
        return Camera((middle[0], 0.0, 4.4 * length), middle, (0.0, 1.0, 0.0))
    return Camera((middle[0] - length, -2.4 * length, 2.2 * length), middle, (0.0, 0.0, 1.0))
